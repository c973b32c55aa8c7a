// The raster map: the OctoMap projected along z between floor clearance and robot height, with free
// space and with honest unknowns.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/grid/tiled_grid.hpp"

namespace fusion_slam {

// One column of voxels of the band, log-odds in steps (kUnknownVoxel: never seen), to the byte of
// its cell:
// - occupied as its most occupied voxel, when that one is more likely occupied than not;
// - else free by the mean of all voxels, where one that was never seen counts as 0 (p = 0.5): a
// column of which only a part
//   was seen free is only partly free, and below about half it stays without a verdict;
// - unknown when none was seen.
std::uint8_t raster_cell(const std::vector<std::int8_t>& column);

// `band`: 64 x 64 x n voxels, x fastest, then y.
TileCells raster_tile(const std::vector<std::int8_t>& band);

}  // namespace fusion_slam
