// A route file (config/routes/*.yaml): a robot's way through a world that has none of its own, or
// another way through one that has; and, where they matter, its camera and noise.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/yaml_section.hpp"

namespace fusion_slam {

// The camera on the robot: base frame x forward, z up, on the floor. Looks along x.
struct RouteCamera {
  double fx_px = 570.0;
  double fy_px = 570.0;
  double cx_px = 319.5;
  double cy_px = 239.5;
  int width_px = 640;
  int height_px = 480;
  double rate_hz = 30.0;
  double x_m = 0.10;
  double z_m = 0.35;
  double pitch_rad = 0.0;  // positive looks down
};

struct RouteNoise {
  double value = 0.0;
  std::string place;  // "file:line", for messages of whoever knows the names
};

struct Route {
  std::string name;
  std::vector<Eigen::Vector2d> way_points_m;  // world; two or more
  DriveLimits limits;
  std::optional<double> seconds;               // how long the drive takes
  std::optional<RouteCamera> camera;           // instead of the robot's own
  std::map<std::string, RouteNoise> noise;     // values by name, instead of the sensors' own
  std::map<std::string, std::string> without;  // effects to leave out: name -> "file:line"
};

// Keys (metres, degrees):
//   name; route: [[x, y], ...]; seconds;
//   limits: {speed_m_s, turn_rad_s, accel_m_s2, turn_accel_rad_s2};
//   camera: {fx, fy, cx, cy, width, height, rate_hz, x_m, z_m, pitch_deg} (each optional);
//   noise: {name: number, ...}; without: [name, ...]. The names are the sensors' (recording.hpp).
// Throws ConfigError with file, line, key and the nearest valid key.
Route load_route(const std::filesystem::path& path);
Route route_from_text(const std::string& text, const std::string& file_name);

// Parts that world files have too: `route` (two or more way points when it is there) and `limits`.
std::vector<Eigen::Vector2d> read_way_points(const YamlSection& section);
DriveLimits read_limits(const YamlSection& section);

}  // namespace fusion_slam
