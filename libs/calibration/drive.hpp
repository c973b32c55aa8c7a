// What calibration looks at: one ordinary drive, each sensor in its own frame and by its own clock.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/calibration/planar_path.hpp"
#include "libs/camera/camera_model.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

// A depth pixel: its ray at z = 1 (camera optical frame) and its inverse depth, in which the noise
// of a triangulating camera is even.
struct DepthRay {
  float x = 0.0F;
  float y = 0.0F;
  float inverse_m = 0.0F;
  Eigen::Vector3d ray() const { return {x, y, 1.0}; }
  Eigen::Vector3d point_m() const { return ray() / inverse_m; }
};

struct DepthFrame {
  std::int64_t utime_us = 0;                   // of the depth image
  std::vector<std::vector<DepthRay>> columns;  // sampled, left to right; top to bottom
};

struct CalibrationDrive {
  RobotModel robot;  // the mounting on paper: where the search begins
  CameraModel camera;
  std::vector<DepthFrame> frames;  // a few a second
  std::vector<LaserScan> scans;
  PlanarPath lidar;     // T_odom_lidar at the scans' stamps, by scan matching alone
  PlanarPath odometry;  // T_odom_base of the wheels, in an odom of their own; may be empty
};

}  // namespace fusion_slam
