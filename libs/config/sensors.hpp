// Sensor models by name: config/sensors/NAME.yaml. What a data sheet says, the same for every
// robot.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

// How to reach a LiDAR; the optional keys port, baud, model and scan_mode of its file.
struct LidarConnection {
  std::string port;                // device file, pattern with *, or empty: the driver looks for it
  int baud = 0;                    // 0: the driver finds out
  std::string model;               // a1, a2, a3, c1, s1, s2, s3; empty: whatever answers
  std::string scan_mode = "auto";  // auto, standard, express, dense
};

// How to reach an RGB-D camera and what to ask of it; optional keys of its file
// (config/sensors/orbbec-astra.yaml explains them).
struct CameraConnection {
  std::string uri;                    // of the OpenNI2 device; empty: the first one
  std::string colour = "openni2";     // or a UVC camera: /dev/video0
  std::string intrinsics = "file";    // file, device
  std::string registration = "auto";  // auto, device, own, none
  bool auto_exposure = true;
  int jpeg_quality = 90;
  std::string images = "plain";  // plain, packed: half of the network, for our programs only
  double stamp_offset_ms = 0.0;  // added to the stamps of its images
  // The depth camera, for registration by us. fx 0: what the device says.
  double depth_fx_px = 0.0;
  double depth_fy_px = 0.0;
  double depth_cx_px = 0.0;
  double depth_cy_px = 0.0;
  std::optional<SE3> T_colour_depth;  // both optical frames
};

// All throw ConfigError with file, line and key; an unknown keys' nearest valid one is named.
LidarModel load_lidar_model(const std::filesystem::path& path);
LidarConnection load_lidar_connection(const std::filesystem::path& path);
CameraModel load_camera_model(const std::filesystem::path& path);
CameraConnection load_camera_connection(const std::filesystem::path& path);

// Names of the sensors of `kind` ("lidar" or "camera") in a directory, sorted.
std::vector<std::string> sensor_names(const std::filesystem::path& directory,
                                      const std::string& kind);

}  // namespace fusion_slam
