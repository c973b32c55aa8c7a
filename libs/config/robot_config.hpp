// A robot's description: config/robots/NAME.yaml. Eleven keys, all optional but one sensor:
//
//   name                       what people call it
//   lidar, camera              sensor models: names of files in ../sensors beside robots/
//   lidar_mount_xyz_m_rpy_deg  [x, y, z, roll, pitch, yaw] of the sensor in base (x forward, y
//                              left, z up, on the floor)
//   camera_mount_xyz_m_rpy_deg a camera looks along its mounting's x axis (pitch > 0: downwards)
//   odometry                   true: the robot publishes ODOMETRY
//   planar                     true: it drives on a flat floor
//   reference_frame            base, camera or lidar: whose pose the trajectory is
//   map_resolution_m, floor_clearance_m, robot_height_m
#pragma once

#include <filesystem>
#include <string>

#include "libs/camera/camera_model.hpp"
#include "libs/config/yaml_map.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct RobotConfig {
  RobotModel robot;
  CameraModel camera;                 // meaningful when robot.has_camera
  std::filesystem::path lidar_file;   // the LiDAR's sensor model; empty without one
  std::filesystem::path camera_file;  // the camera's
};

// Throws ConfigError: file, line, key, what to do.
RobotConfig load_robot_config(const std::filesystem::path& path);

// The same for what people give on a command line: NAME for config/robots/NAME.yaml, or a file (it
// has a / or ends in .yaml). Throws ConfigError also when there is no such robot.
RobotConfig find_robot(const std::string& robot);

// The directory that holds robots/ and sensors/: $FUSION_SLAM_CONFIG, else config/ or
// share/fusion-slam/config/ in the nearest directory above this program. Throws ConfigError when
// there is none.
std::filesystem::path config_directory();

}  // namespace fusion_slam
