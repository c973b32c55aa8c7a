// Sensor models by name: config/sensors/NAME.yaml. What a data sheet says, the same for every
// robot.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

// Both throw ConfigError with file, line and key; an unknown keys' nearest valid one is named.
LidarModel load_lidar_model(const std::filesystem::path& path);
CameraModel load_camera_model(const std::filesystem::path& path);

// Names of the sensors of `kind` ("lidar" or "camera") in a directory, sorted.
std::vector<std::string> sensor_names(const std::filesystem::path& directory,
                                      const std::string& kind);

}  // namespace fusion_slam
