// What a session's log says about the run itself: the health of the processes over time, the loops
// it closed, the robot. Knows the message types but no bus.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/graph/node_id.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct HealthPoint {
  double time_s = 0.0;  // wall clock, since the first STATUS of the session
  double latency_ms_p95 = 0.0;
  double peak_rss_bytes = 0.0;
  double cpu_s = 0.0;
  double queue = 0.0;
};

struct ClosedLoop {
  NodeId from, to;
  std::string source;
  bool switched_off = false;
  std::string reason;  // why it was switched off
};

struct SessionHistory {
  std::map<std::string, std::vector<HealthPoint>> health;  // by process
  std::map<NodeId, std::int64_t> node_utime_us;
  std::vector<ClosedLoop> loops;
  std::optional<RobotModel> robot;
  std::optional<CameraModel> camera;
  std::string damage;  // what was wrong with the log; empty: nothing
};

// Throws std::runtime_error when the file is no LCM log; damage inside is skipped and named.
SessionHistory read_history(const std::filesystem::path& session);

}  // namespace fusion_slam
