// Where the sensors sit and what they can do; the plain form of ROBOT_MODEL.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// The frame whose pose GROUND_TRUTH and trajectory.tum give.
enum class ReferenceFrame { kBase, kCamera, kLidar };

struct LidarModel {
  double range_min_m = 0.15;
  double range_max_m = 12.0;
  double sigma_m = 0.02;  // standard deviation of a range
  double rate_hz = 5.5;
  double beam_period_s = 0.0;  // beam i was measured at utime + i * this; 0: all at once
};

struct RobotModel {
  std::string name = "robot";
  ReferenceFrame reference_frame = ReferenceFrame::kBase;
  bool has_lidar = false;
  bool has_camera = false;
  bool has_odometry = false;
  bool planar = true;  // base moves on a flat floor: z, roll and pitch are 0
  SE3 T_base_lidar = SE3::Identity();
  SE3 T_base_camera = SE3::Identity();
  LidarModel lidar;
  double map_resolution_m = 0.05;
  double floor_clearance_m = 0.05;
  double robot_height_m = 0.60;

  // T_base_reference: the pose of the reference frame in base.
  SE3 T_base_reference() const {
    if (reference_frame == ReferenceFrame::kCamera) return T_base_camera;
    if (reference_frame == ReferenceFrame::kLidar) return T_base_lidar;
    return SE3::Identity();
  }
};

// One sweep of a 2D LiDAR as it came. Beam i points at rad0 + i * radstep in the lidar's frame.
struct LaserScan {
  std::int64_t utime_us = 0;  // of the first beam
  double rad0 = 0.0;
  double radstep = 0.0;         // negative: clockwise
  std::vector<float> ranges_m;  // anything outside the model's range, nan and inf: no return
  std::vector<float> intensities;
};

}  // namespace fusion_slam
