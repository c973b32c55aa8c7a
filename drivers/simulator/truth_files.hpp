// The ground truth of a world as files, beside the recording made in it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drivers/simulator/truth_map.hpp"
#include "drivers/simulator/world.hpp"
#include "libs/cloud/cloud_tile.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

// Points on every surface of the world (seen or not, but nothing below the floor), spacing_m apart
// along both edges of each face, coloured by obstacle class. Deterministic.
std::vector<ColouredPoint> sample_surfaces(const std::vector<Box>& boxes,
                                           const std::vector<TruthTriangle>& triangles,
                                           double spacing_m);

// map.pgm of the classes: grey value = ObstacleClass, 0 where nothing is known to stand; the same
// cells as the true map's map.pgm.
std::string class_pgm_bytes(const TruthMap& map);

// Writes into `directory` (made when needed), each file whole or not at all:
//   map.pgm, map.yaml  what a robot of this height and floor clearance would hit (truth_map.hpp)
//   classes.pgm        the obstacle class of each occupied cell
//   map.png            for people, with the route
//   surfaces.ply       sample_surfaces() at the resolution
// The route's first way point is where the robot starts. Throws std::runtime_error: it starts in an
// obstacle, or a file can't be written.
TruthMap write_truth(const World& world, const std::vector<Eigen::Vector2d>& route_m,
                     const RobotModel& robot, double resolution_m,
                     const std::filesystem::path& directory);

}  // namespace fusion_slam
