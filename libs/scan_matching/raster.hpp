// What scans are matched against: a dense grid of cell bytes (libs/grid: 0 unknown, 1..255
// probability of occupied).
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "libs/grid/tiled_grid.hpp"
#include "libs/scan_matching/dense_grid.hpp"

namespace fusion_slam {

using Raster = DenseGrid<std::uint8_t>;

// End points of a scan, metres, in the frame that is being placed (base).
using Points = std::vector<Eigen::Vector2d>;

// Where nothing is known a beam is about as unlikely to end as in free space.
constexpr double kUnknownMatchProbability = 0.1;

// How probable it is that a beam ends in a cell, by the cell's byte; in [0.1, 0.98].
const std::array<float, 256>& match_probability();

// All tiles of a submap in one piece.
Raster raster_from_tiles(const TiledGrid& grid);

}  // namespace fusion_slam
