// All that simulated sensors do wrong, by name: effects that can be left out one by one, and
// parameters that a route file may set. Defaults and their sources stand in camera_noise.hpp,
// lidar_sensor.hpp, drive.hpp and here.
#pragma once

#include <string>
#include <vector>

#include "drivers/simulator/camera_noise.hpp"
#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/lidar_sensor.hpp"

namespace fusion_slam {

// Stamps are made by the host when USB packets come, not by the sensor.
struct StampNoise {
  double camera_jitter_s = 0.001;  // standard deviation; usual for a loaded Linux host with USB
  double depth_jitter_s = 0.001;   // of the depth image's own stamp, besides
  double lidar_jitter_s = 0.001;
  bool with_jitter = true;
};

struct SensorNoise {
  CameraNoise camera;
  LidarNoise lidar;
  WheelNoise wheels;
  StampNoise stamps;
};

// In the order in which people read them: colour-noise, photon-noise, exposure, motion-blur,
// rolling-shutter (off by default), depth-noise, depth-correlation, depth-steps, depth-edges,
// depth-shadow, depth-dropouts, depth-delay, jitter, lidar-noise, lidar-dropouts, lidar-sweep,
// wheel-scale, slip.
struct Effect {
  std::string name;
  std::string meaning;
  bool on_by_default = true;
};
const std::vector<Effect>& effects();

// Switches an effect; "all" switches every one (rolling-shutter only off). Throws
// std::invalid_argument naming the nearest effect when there is no such one.
void set_effect(const std::string& name, bool on, SensorNoise* noise);
bool effect_is_on(const std::string& name, const SensorNoise& noise);

// Sets a parameter: any double of the four structs by its member's name, such as colour_sigma.
// Throws std::invalid_argument naming the nearest parameter, or the range.
void set_parameter(const std::string& name, double value, SensorNoise* noise);
double parameter(const std::string& name, const SensorNoise& noise);
std::vector<std::string> parameter_names();

}  // namespace fusion_slam
