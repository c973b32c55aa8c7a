#include "viz/web/session_replay.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "libs/messages/convert.hpp"
#include "viz/web/decode.hpp"

namespace fusion_slam {
namespace {

template <class Message>
bool hand_over(const LogEvent& event, ViewerState& state) {
  const auto message = decode_guarded<Message>(event.data);
  if (message) state.on(event.channel, *message);
  return message.has_value();
}

bool hand_over_tile(const LogEvent& event, ViewerState& state) {
  const auto message = decode_guarded<tile_t>(event.data);
  if (message) state.on_tile(event.channel, from_message(*message));
  return message.has_value();
}

using Handler = bool (*)(const LogEvent&, ViewerState&);

const std::map<std::string, Handler>& handlers() {
  static const std::map<std::string, Handler> kHandlers{
      {"CAMERA", hand_over<bot_core::images_t>},
      {"LIDAR", hand_over<bot_core::planar_lidar_t>},
      {"ODOMETRY", hand_over<bot_core::pose_t>},
      {"GROUND_TRUTH", hand_over<bot_core::pose_t>},
      {"CAMERA_MODEL", hand_over<camera_model_t>},
      {"ROBOT_MODEL", hand_over<robot_model_t>},
      {"VISUAL_POSE", hand_over<pose_estimate_t>},
      {"LIDAR_POSE", hand_over<pose_estimate_t>},
      {"POSE", hand_over<pose_estimate_t>},
      {"LOCALIZATION", hand_over<pose_estimate_t>},
      {"KEYFRAME", hand_over<keyframe_t>},
      {"KEYFRAME_IMAGE", hand_over<keyframe_image_t>},
      {"LIDAR_NODE", hand_over<lidar_node_t>},
      {"GRAPH", hand_over<graph_t>},
      {"LOOP_CANDIDATE", hand_over<loop_candidate_t>},
      {"CONSTRAINT", hand_over<constraint_t>},
      {"COMMAND", hand_over<command_t>},
      {"STATUS", hand_over<status_t>},
      {"PM_INFO", hand_over<procman_lcm::deputy_info_t>},
      {"GRID_FUSED", hand_over_tile},
      {"GRID_LIDAR", hand_over_tile},
      {"GRID_VISUAL", hand_over_tile},
      {"OCTOMAP", hand_over_tile},
      {"CLOUD", hand_over_tile}};
  return kHandlers;
}

bool is_sensor(const std::string& channel) {
  return channel == "CAMERA" || channel == "LIDAR" || channel == "ODOMETRY" ||
         channel == "GROUND_TRUTH";
}

}  // namespace

bool apply_event(const LogEvent& event, ViewerState& state) {
  const auto handler = handlers().find(event.channel);
  return handler != handlers().end() && handler->second(event, state);
}

SessionReplay::SessionReplay(const std::filesystem::path& log,
                             const std::function<bool(double)>& progress)
    : reader_(log) {
  LogEvent event;
  std::int64_t n = 0;
  const auto size = static_cast<double>(std::max<std::int64_t>(1, reader_.size_bytes()));
  for (;;) {
    if (!reader_.next(&event)) {
      if (!reader_.damage()) break;
      if (damage_.empty()) damage_ = reader_.damage()->message;
      if (!reader_.resync()) break;
      continue;
    }
    index(event);
    if (++n % 256 == 0 && !progress(static_cast<double>(reader_.offset_bytes()) / size)) {
      entries_.clear();
      return;
    }
  }
  if (entries_.empty())
    throw std::runtime_error(log.string() +
                             ": nothing in it that can be shown (no sensors, maps or poses of "
                             "Fusion-SLAM); `fusion-slam info` says what it holds");
  // What was logged before the first measurement belongs to it.
  const auto timed = std::find_if(entries_.begin(), entries_.end(),
                                  [](const Entry& entry) { return entry.utime_us > 0; });
  first_us_ = timed == entries_.end() ? 0 : timed->utime_us;
  for (auto entry = entries_.begin(); entry != timed; ++entry) entry->utime_us = first_us_;
  last_us_ = entries_.back().utime_us;
}

std::uint32_t SessionReplay::number_of(const std::string& what) {
  return numbers_.try_emplace(what, static_cast<std::uint32_t>(numbers_.size() + 1)).first->second;
}

void SessionReplay::index(const LogEvent& event) {
  const std::string& channel = event.channel;
  if (handlers().count(channel) == 0) return;
  if (is_sensor(channel)) {
    const auto utime_us = peek_utime(event.data.data(), event.data.size());
    // One stamp that is far off must not stretch the time line.
    const bool plausible = utime_us && (now_us_ == 0 || *utime_us < now_us_ + 3'600'000'000);
    if (plausible) now_us_ = std::max(now_us_, *utime_us);
  }
  Entry entry{event.offset_bytes, now_us_, 0};
  if (channel == "CAMERA" || channel == "LIDAR" || channel == "ODOMETRY" ||
      channel == "KEYFRAME_IMAGE" || channel == "ROBOT_MODEL" || channel == "CAMERA_MODEL") {
    entry.replaces = number_of(channel);
  } else if (channel == "STATUS") {
    if (const auto status = decode_guarded<status_t>(event.data))
      entry.replaces = number_of("STATUS " + status->process);
  } else if (channel == "OCTOMAP" || channel == "CLOUD") {
    if (const auto tile = decode_guarded<tile_t>(event.data))
      entry.replaces = number_of(channel + " " + std::to_string(tile->submap_id) + " " +
                                 std::to_string(tile->x) + " " + std::to_string(tile->y) + " " +
                                 std::to_string(tile->z));
  } else if (channel == "CONSTRAINT") {
    closures_us_.push_back(now_us_);
  }
  entries_.push_back(entry);
}

void SessionReplay::go_to(std::int64_t utime_us, ViewerState& state) {
  const auto end = static_cast<std::size_t>(
      std::upper_bound(entries_.begin(), entries_.end(), utime_us,
                       [](std::int64_t t, const Entry& entry) { return t < entry.utime_us; }) -
      entries_.begin());
  if (end < next_) {
    state.clear();
    next_ = 0;
  }
  // Backwards: the first of a number that is met is the one that counts.
  std::vector<std::size_t> needed;
  std::set<std::uint32_t> seen;
  for (std::size_t i = end; i > next_; --i) {
    const Entry& entry = entries_[i - 1];
    const bool is_newest = entry.replaces == 0 || seen.insert(entry.replaces).second;
    if (is_newest || entry.utime_us > utime_us - kWhole_us) needed.push_back(i - 1);
  }
  for (auto i = needed.rbegin(); i != needed.rend(); ++i) apply(entries_[*i], state);
  next_ = end;
}

void SessionReplay::apply(const Entry& entry, ViewerState& state) {
  LogEvent event;
  reader_.seek(entry.offset);
  if (!reader_.next(&event)) return;
  apply_event(event, state);
  ++applied_;
}

}  // namespace fusion_slam
