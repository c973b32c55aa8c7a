#include "logplayer/run/playback.hpp"

#include "libs/eventlog/reader.hpp"
#include "logplayer/run/interrupt.hpp"

namespace fusion_slam {

PlaybackResult play_log(const std::filesystem::path& log, std::int64_t most_events,
                        Conductor& conductor, Progress& progress,
                        const std::function<void(const LogEvent&)>& on_event) {
  PlaybackResult result;
  LogReader reader(log);
  LogEvent event;
  std::int64_t n = 0;
  while ((most_events == 0 || n < most_events) && reader.next(&event)) {
    if (interrupts() > 0) {
      result.interrupted = true;
      return result;
    }
    if (!is_sensor_channel(event.channel)) continue;
    if (n++ == 0) result.first_utime_us = event.timestamp_us;
    result.last_utime_us = event.timestamp_us;
    on_event(event);
    if (conductor.play(event))
      ++result.played[event.channel];
    else
      ++result.repeats_skipped;
    const double done = most_events > 0 ? static_cast<double>(n) / static_cast<double>(most_events)
                                        : static_cast<double>(reader.offset_bytes()) /
                                              static_cast<double>(reader.size_bytes());
    progress.show(done, 1e-6 * static_cast<double>(result.last_utime_us - result.first_utime_us),
                  conductor.peers());
  }
  if (reader.damage()) result.damage = reader.damage()->message;
  if (n == 0 && result.damage.empty())
    result.damage = log.string() +
                    " holds none of CAMERA, LIDAR, ODOMETRY and the like: `fusion-slam info` says "
                    "what it holds, `fusion-slam import` turns recordings into logs";
  return result;
}

}  // namespace fusion_slam
