// A whole 2D map as one picture of cells, cut from tiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/grid/cell_state.hpp"
#include "libs/grid/fused_tile.hpp"
#include "libs/grid/tiled_grid.hpp"

namespace fusion_slam {

// Row 0 is the lowest y, column 0 the lowest x: cell (column, row) covers origin + [column, column
// + 1) * resolution_m.
struct MapRaster {
  double resolution_m = 0.05;
  double origin_x_m = 0.0;
  double origin_y_m = 0.0;
  int width = 0;                          // cells
  int height = 0;                         // cells
  std::vector<std::uint8_t> probability;  // as in tiled_grid.hpp
  std::vector<std::uint8_t> provenance;   // values of Provenance

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  }
};

// The smallest raster that holds every known cell. Nothing, with the reason in `why`, when no cell
// is known or the map would be larger than 2^27 cells (a damaged tile index).
std::optional<MapRaster> make_raster(const std::map<TileIndex, FusedCells>& tiles,
                                     double resolution_m, std::string* why);

}  // namespace fusion_slam
