#include "services/dense_mapper/raster.hpp"

#include <algorithm>
#include <cmath>

#include "libs/octree/octomap_tile.hpp"

namespace fusion_slam {

std::uint8_t raster_cell(const std::vector<std::int8_t>& column) {
  std::int8_t highest = kUnknownVoxel;
  int free_sum = 0;
  for (const std::int8_t steps : column) {
    if (steps == kUnknownVoxel) continue;
    highest = std::max(highest, steps);
    free_sum += steps;
  }
  if (highest == kUnknownVoxel) return kUnknownCell;
  const double steps = highest > 0 ? highest : free_sum / static_cast<double>(column.size());
  return cell_from_probability(1.0 / (1.0 + std::exp(-steps * kLogOddsStep)));
}

TileCells raster_tile(const std::vector<std::int8_t>& band) {
  TileCells cells;
  const std::size_t n = band.size() / cells.size();
  std::vector<std::int8_t> column(n);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (std::size_t z = 0; z < n; ++z) column[z] = band[z * cells.size() + i];
    cells[i] = raster_cell(column);
  }
  return cells;
}

}  // namespace fusion_slam
