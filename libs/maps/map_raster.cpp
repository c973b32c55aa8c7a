#include "libs/maps/map_raster.hpp"

#include <algorithm>
#include <limits>

namespace fusion_slam {
namespace {

constexpr std::int64_t kMaxCells = std::int64_t{1} << 27;

struct Bounds {  // inclusive, in cells
  std::int64_t min_x = std::numeric_limits<std::int64_t>::max();
  std::int64_t min_y = std::numeric_limits<std::int64_t>::max();
  std::int64_t max_x = std::numeric_limits<std::int64_t>::min();
  std::int64_t max_y = std::numeric_limits<std::int64_t>::min();

  void include(std::int64_t x, std::int64_t y) {
    min_x = std::min(min_x, x);
    min_y = std::min(min_y, y);
    max_x = std::max(max_x, x);
    max_y = std::max(max_y, y);
  }
};

// Calls visit(cell x, cell y, index in tile) for each known cell of a tile.
template <class Visit>
void for_known_cells(const TileIndex& index, const FusedCells& cells, Visit visit) {
  for (int y = 0; y < kTileCells; ++y) {
    for (int x = 0; x < kTileCells; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x);
      if (cells.probability[i] != kUnknownCell)
        visit(std::int64_t{index.first} * kTileCells + x,
              std::int64_t{index.second} * kTileCells + y, i);
    }
  }
}

}  // namespace

std::optional<MapRaster> make_raster(const std::map<TileIndex, FusedCells>& tiles,
                                     double resolution_m, std::string* why) {
  Bounds bounds;
  for (const auto& [index, cells] : tiles)
    for_known_cells(index, cells,
                    [&](std::int64_t x, std::int64_t y, std::size_t) { bounds.include(x, y); });
  if (bounds.max_x < bounds.min_x) return *why = "no cell of the map is known", std::nullopt;
  const std::int64_t width = bounds.max_x - bounds.min_x + 1;
  const std::int64_t height = bounds.max_y - bounds.min_y + 1;
  if (width > kMaxCells || height > kMaxCells || width * height > kMaxCells)
    return *why = "the map would be " + std::to_string(width) + " x " + std::to_string(height) +
                  " cells: a tile has a damaged index",
           std::nullopt;

  MapRaster raster;
  raster.resolution_m = resolution_m;
  raster.origin_x_m = static_cast<double>(bounds.min_x) * resolution_m;
  raster.origin_y_m = static_cast<double>(bounds.min_y) * resolution_m;
  raster.width = static_cast<int>(width);
  raster.height = static_cast<int>(height);
  raster.probability.assign(static_cast<std::size_t>(width * height), kUnknownCell);
  raster.provenance.assign(raster.probability.size(), 0);
  for (const auto& [index, cells] : tiles)
    for_known_cells(index, cells, [&, &c = cells](std::int64_t x, std::int64_t y, std::size_t i) {
      const std::size_t at =
          raster.index(static_cast<int>(x - bounds.min_x), static_cast<int>(y - bounds.min_y));
      raster.probability[at] = c.probability[i];
      raster.provenance[at] = c.provenance[i];
    });
  return raster;
}

}  // namespace fusion_slam
