#include "logplayer/run/playback.hpp"

#include <algorithm>
#include <cstdint>
#include <deque>
#include <utility>

#include "fusion_slam/robot_model_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/schema/guard.hpp"
#include "logplayer/run/interrupt.hpp"

namespace fusion_slam {
namespace {

void note_sensor_time(const LogEvent& event, PlaybackResult* result) {
  if (event.channel != "CAMERA" && event.channel != "LIDAR") return;
  const auto utime_us = peek_utime(event.data.data(), event.data.size());
  if (!utime_us) return;
  if (result->first_sensor_utime_us == 0) result->first_sensor_utime_us = *utime_us;
  result->last_sensor_utime_us = *utime_us;
}

// The events of a log that are played, and the next frame of the camera before it is its turn.
class Upcoming {
 public:
  Upcoming(const std::filesystem::path& log, const std::set<std::string>& without)
      : reader_(log), without_(without) {}

  bool next(LogEvent* event) {
    if (window_.empty() && !read()) return false;
    *event = std::move(window_.front());
    window_.pop_front();
    return true;
  }
  // Null: none among the next `most` events, of which there are not many in memory.
  const LogEvent* frame(std::int64_t most) {
    constexpr std::int64_t kWindow = 64;
    for (std::int64_t i = 0; i < std::min(most, kWindow); ++i) {
      if (i == static_cast<std::int64_t>(window_.size()) && !read()) return nullptr;
      const LogEvent& event = window_[static_cast<std::size_t>(i)];
      if (event.channel == "CAMERA") return &event;
    }
    return nullptr;
  }
  const LogReader& reader() const { return reader_; }

 private:
  bool read() {
    LogEvent event;
    while (reader_.next(&event)) {
      if (!is_sensor_channel(event.channel) || !left_in(without_, &event)) continue;
      window_.push_back(std::move(event));
      return true;
    }
    return false;
  }

  LogReader reader_;
  const std::set<std::string>& without_;
  std::deque<LogEvent> window_;
};

}  // namespace

bool left_in(const std::set<std::string>& without, LogEvent* event) {
  if (without.empty()) return true;
  const auto is = [&](const char* input) { return without.count(input) > 0; };
  const std::string& channel = event->channel;
  if (channel == "CAMERA" || channel == "CAMERA_MODEL") return !is("camera");
  if (channel == "LIDAR") return !is("lidar");
  if (channel == "ODOMETRY") return !is("odometry");
  robot_model_t robot{};
  if (channel != "ROBOT_MODEL" ||
      robot.decode(event->data.data(), 0, static_cast<int>(event->data.size())) < 0)
    return true;
  if (is("camera")) robot.has_camera = 0;
  if (is("lidar")) robot.has_lidar = 0;
  if (is("odometry")) robot.has_odometry = 0;
  event->data.resize(static_cast<std::size_t>(robot.getEncodedSize()));
  robot.encode(event->data.data(), 0, static_cast<int>(event->data.size()));
  return true;
}

void play_log(const std::filesystem::path& log, std::int64_t most_events,
              const std::set<std::string>& without, Conductor& conductor, Progress& progress,
              const std::function<void(const LogEvent&)>& on_event, PlaybackResult* result) {
  Upcoming upcoming(log, without);
  LogEvent event;
  std::int64_t n = 0;
  while ((most_events == 0 || n < most_events) && upcoming.next(&event)) {
    if (interrupts() > 0) {
      result->interrupted = true;
      return;
    }
    if (n++ == 0) result->first_utime_us = event.timestamp_us;
    result->last_utime_us = event.timestamp_us;
    const std::int64_t left = most_events == 0 ? INT64_MAX : most_events - n;
    switch (conductor.play(event, upcoming.frame(left))) {
      case Played::kYes:
        ++result->played[event.channel];
        note_sensor_time(event, result);
        on_event(event);
        break;
      case Played::kRepeat:
        ++result->repeats_skipped;
        break;
      case Played::kUndecodable:
        ++result->undecodable_skipped;
        break;
    }
    const double done = most_events > 0 ? static_cast<double>(n) / static_cast<double>(most_events)
                                        : static_cast<double>(upcoming.reader().offset_bytes()) /
                                              static_cast<double>(upcoming.reader().size_bytes());
    progress.show(done, 1e-6 * static_cast<double>(result->last_utime_us - result->first_utime_us),
                  conductor.peers());
  }
  progress.show(1.0, 1e-6 * static_cast<double>(result->last_utime_us - result->first_utime_us),
                conductor.peers(), true);
  if (upcoming.reader().damage()) result->damage = upcoming.reader().damage()->message;
  if (n == 0 && result->damage.empty())
    result->damage = log.string() +
                     " holds none of CAMERA, LIDAR, ODOMETRY and the like: `fusion-slam info` says "
                     "what it holds, `fusion-slam import` turns recordings into logs";
}

}  // namespace fusion_slam
