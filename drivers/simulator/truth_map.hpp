// The 2D map that a perfect robot would make of a world: what it would hit, where it can go, and
// what kind of thing stands where. Pure functions, callable from any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "drivers/simulator/truth_solids.hpp"
#include "libs/maps/map_raster.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct TruthOptions {
  double resolution_m = 0.05;
  HeightBand band;
  double lidar_height_m = 0.20;  // a thing of no class whose top is lower becomes a kLowBox
};
TruthOptions truth_options_for(const RobotModel& robot);

// Cells are 255 (occupied), 1 (free) or kUnknownCell. A cell is
// - an obstacle when any part of it has something of the world above it within the band;
// - free when it is none and can be reached over free cells (4 neighbours) from the start;
// - occupied when it is an obstacle that can be seen from free cells: sight goes (8 neighbours)
//   through free cells and over or under obstacles that leave kSightGap_m of the band open, and
//   ends on the first cell that is blocked;
// - unknown otherwise: inside of solids, behind walls, outside.
struct TruthMap {
  MapRaster raster;
  std::vector<std::uint8_t> classes;  // ObstacleClass by raster.index(); kNone where not occupied
  bool closed = true;                 // false: free space reaches the edge of the raster
};

constexpr double kSightGap_m = 0.10;

// Where a robot may start: not in an obstacle. Throws std::runtime_error when `start_m` is one or
// the world is larger than 2^27 cells.
TruthMap make_truth_map(const std::vector<Box>& boxes, const std::vector<TruthTriangle>& triangles,
                        const Eigen::Vector2d& start_m, const TruthOptions& options);

// Distance from a point to the nearest occupied cell (its nearest point); up_to_m when none is
// nearer.
double nearest_obstacle_m(const TruthMap& map, const Eigen::Vector2d& point_m, double up_to_m);

}  // namespace fusion_slam
