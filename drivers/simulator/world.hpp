// A world file (config/worlds/*.yaml): what stands where, and the robot's way through it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/scene.hpp"
#include "drivers/simulator/surface.hpp"

namespace fusion_slam {

struct World {
  std::string name;
  std::vector<Box> boxes;
  Lighting lighting;
  std::vector<Eigen::Vector2d> route_m;
  DriveLimits limits;
};

// Keys (lengths in metres, angles in degrees, counter-clockwise from x):
//   name; route: [[x, y], ...]; limits: {speed_m_s, turn_rad_s, accel_m_s2, turn_accel_rad_s2};
//   lamps: [[x, y, z], ...]
//   things: a list of {kind, at: [x, y] or [x, y, z of its lower face], yaw_deg, size_m: [x, y, z],
//     texture, colour: [r, g, b] of 255}. kind: box | desk | table | chair | picture; a picture's
//     size is [width, height], it looks along its yaw from a wall behind it, and z is its lower
//     edge.
//   walls: a list of {from: [x, y], to: [x, y], height_m, thickness_m, base_m, texture, colour}
//   class of a thing or wall: wall | chair | table | low_box | other, for the true map; from its
//     kind when not given (desk and table: table, picture: wall; a box under the LiDAR's plane:
//     low_box).
// Throws ConfigError with file, line, key and the nearest valid key.
World load_world(const std::filesystem::path& path);
World world_from_text(const std::string& text, const std::string& file_name);

}  // namespace fusion_slam
