// One way to read what visual odometry listens to: a 7-Scenes or TUM RGB-D directory, or an LCM
// event log.
#pragma once

#include <functional>
#include <string>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/evaluation/trajectory.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct BenchListener {
  // First of all, once.
  std::function<void(const CameraModel&, const RobotModel&)> models;
  std::function<void(const RgbdFrame&)> frame;
  std::function<void(const LaserScan&)> scan;
  std::function<void(std::int64_t utime_us, const SE3& T_odom_base)> lidar_pose;
  std::function<void(std::int64_t utime_us, const SE3& T_odom_base)> odometry;  // wheels
  std::function<void(std::int64_t keyframe, const SE3& T_map_base)> graph_node;
};

// Plays the recording in order of time and returns its reference: T_world of the robot's reference
// frame. `lidar_poses`, `graph`: logs that hold LIDAR_POSE, and GRAPH, of the same drive
// (session.lcmlog of a run); may be empty. Throws std::runtime_error with the path when it can't be
// read.
Trajectory play_recording(const std::string& path, const std::string& lidar_poses,
                          const std::string& graph, const BenchListener& listener);

}  // namespace fusion_slam
