#include "tests/bench/dense_map/bench_log.hpp"

#include <stdexcept>

#include "bot_core/pose_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

template <class Message>
Message decode(const LogEvent& event) {
  Message message;
  if (message.decode(event.data.data(), 0, static_cast<int>(event.data.size())) < 0)
    throw std::runtime_error(event.channel + " is damaged");
  return message;
}

}  // namespace

SE3 BenchLog::pose_at(std::int64_t utime_us) const {
  const auto after = T_world_base.lower_bound(utime_us);
  if (after == T_world_base.end()) return T_world_base.rbegin()->second;
  if (after == T_world_base.begin() || after->first == utime_us) return after->second;
  const auto before = std::prev(after);
  return interpolate(before->second, after->second,
                     static_cast<double>(utime_us - before->first) /
                         static_cast<double>(after->first - before->first));
}

BenchLog read_bench_log(const std::filesystem::path& path, double distance_m, double angle_rad) {
  BenchLog log;
  bool robot = false;
  bool camera = false;
  std::string why;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
  std::optional<SE3> T_world_keyframe;
  LogReader reader(path);
  LogEvent event;
  while (reader.next(&event)) {
    if (event.channel == "ROBOT_MODEL" && !robot) {
      if (const auto model = from_message(decode<robot_model_t>(event), &why)) log.robot = *model;
      robot = true;
    } else if (event.channel == "CAMERA_MODEL" && !camera) {
      if (const auto model = from_message(decode<camera_model_t>(event), &why)) log.camera = *model;
      camera = true;
    } else if (event.channel == "GROUND_TRUTH") {
      const auto message = decode<bot_core::pose_t>(event);
      if (const auto T = from_message(message)) log.T_world_base[message.utime] = *T;
      if (first_us == 0) first_us = message.utime;
      last_us = message.utime;
    } else if (event.channel == "LIDAR") {
      if (const auto scan = from_message(decode<bot_core::planar_lidar_t>(event), &why))
        log.scans.push_back(*scan);
    } else if (event.channel == "CAMERA") {
      auto message = decode<bot_core::images_t>(event);
      const auto T = log.T_world_base.find(message.utime);
      if (T == log.T_world_base.end()) continue;
      if (T_world_keyframe) {
        const SE3 moved = T_world_keyframe->inverse() * T->second;
        if (moved.translation().norm() < distance_m && log_so3(moved.linear()).norm() < angle_rad)
          continue;
      }
      T_world_keyframe = T->second;
      log.keyframes.push_back({message.utime, std::move(message)});
    }
  }
  if (!robot || log.T_world_base.empty())
    throw std::runtime_error(path.string() + " has no ROBOT_MODEL or no GROUND_TRUTH");
  log.seconds = static_cast<double>(last_us - first_us) * 1e-6;
  return log;
}

}  // namespace fusion_slam
