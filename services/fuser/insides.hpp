// What lies within the outline of an obstacle that nobody can look into.
#pragma once

#include <map>

#include "libs/grid/fused_tile.hpp"
#include "libs/grid/tiled_grid.hpp"

namespace fusion_slam {

constexpr double kWidestInside_m = 3.0;  // a bed, a sofa, a row of cupboards; at most a tile

// A low robot sees the sides of a sofa, never its seat. A cell counts as occupied (p = 0.7) when
// - no sensor has a verdict, but the camera has looked over or under it: `camera` isn't unknown;
// - along x and y, in all four directions, the first cell with a verdict within kWidestInside_m is
//   occupied.
// The shadow of an obstacle, which looks the same from one side, ends on free cells; what is as
// high as the band (a pillar) was never looked over and stays unknown.
// Tiles beside `index` are looked up in `fused`, which holds Table 1's answer; where there is none
// nothing has a verdict. camera: of the same tile. Returns the tile with such cells filled; the
// provenance stays (those who have seen it). Pure; any thread.
FusedCells fill_insides(const std::map<TileIndex, FusedCells>& fused, const TileIndex& index,
                        const TileCells& camera, double resolution_m);

}  // namespace fusion_slam
