// A world file (config/worlds/*.yaml): what stands where, and the robot's way through it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/lighting.hpp"
#include "drivers/simulator/scene.hpp"

namespace fusion_slam {

struct World {
  std::string name;
  std::vector<Box> boxes;
  std::vector<Mesh> meshes;  // world frame
  Lighting lighting;
  std::vector<Eigen::Vector2d> route_m;
  DriveLimits limits;
  std::vector<std::string> warnings;  // for people: what is missing or was not understood
};

// Keys (lengths in metres, angles in degrees, counter-clockwise from x):
//   name; route: [[x, y], ...]; limits: {speed_m_s, turn_rad_s, accel_m_s2, turn_accel_rad_s2};
//   lamps: [[x, y, z], ...]
//   things: a list of {kind, at: [x, y] or [x, y, z of its lower face], yaw_deg, size_m: [x, y, z],
//     texture, colour: [r, g, b] of 255}. kind: box | desk | table | chair | picture; a picture's
//     size is [width, height], it looks along its yaw from a wall behind it, and z is its lower
//     edge.
//   walls: a list of {from: [x, y], to: [x, y], height_m, thickness_m, base_m, texture, colour}
//   pattern of a thing or wall: a number; things of equal kind, size and pattern look the same.
//   Each
//     has its own without.
//   class of a thing or wall: wall | chair | table | low_box | other, for the true map; from its
//     kind when not given (desk and table: table, picture: wall; a box under the LiDAR's plane:
//     low_box).
//   a thing of kind mesh: {kind: mesh, file, at, yaw_deg, scale, class}; `file` is a model beside
//   the
//     world file (mesh_file.hpp), its class follows from the file's name.
// Throws ConfigError with file, line, key and the nearest valid key.
// A .world or .sdf file is Gazebo's: see gazebo_world.hpp.
World load_world(const std::filesystem::path& path);
World world_from_text(const std::string& text, const std::string& file_name);

}  // namespace fusion_slam
