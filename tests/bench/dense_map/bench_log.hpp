// A recording with exact ground truth, cut into what the mappers take: keyframes and LiDAR nodes at
// true poses, so that maps are judged without the errors of tracking.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "bot_core/images_t.hpp"
#include "libs/camera/camera_model.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct BenchLog {
  RobotModel robot;
  CameraModel camera;
  std::map<std::int64_t, SE3> T_world_base;  // exact, by utime
  struct Image {
    std::int64_t utime_us = 0;
    bot_core::images_t message;
  };
  std::vector<Image> keyframes;  // at motion, as the visual odometry chooses them
  std::vector<LaserScan> scans;
  double seconds = 0.0;

  SE3 pose_at(std::int64_t utime_us) const;  // interpolated
};

// A keyframe every `distance_m` or `angle_rad` of motion. Throws std::runtime_error when the log
// has no models or no ground truth.
BenchLog read_bench_log(const std::filesystem::path& path, double distance_m, double angle_rad);

}  // namespace fusion_slam
