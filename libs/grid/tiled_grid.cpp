#include "libs/grid/tiled_grid.hpp"

#include <algorithm>

#include "libs/tiles/packed_tile.hpp"

namespace fusion_slam {
namespace {

int floor_div(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

}  // namespace

std::uint8_t TiledGrid::at(int cell_x, int cell_y) const {
  const TileIndex index{floor_div(cell_x, kTileCells), floor_div(cell_y, kTileCells)};
  const auto it = tiles_.find(index);
  if (it == tiles_.end()) return kUnknownCell;
  const int x = cell_x - index.first * kTileCells;
  const int y = cell_y - index.second * kTileCells;
  return it->second[static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x)];
}

void TiledGrid::set(int cell_x, int cell_y, std::uint8_t value) {
  const TileIndex index{floor_div(cell_x, kTileCells), floor_div(cell_y, kTileCells)};
  auto [it, made] = tiles_.try_emplace(index);
  if (made) it->second.fill(kUnknownCell);
  const int x = cell_x - index.first * kTileCells;
  const int y = cell_y - index.second * kTileCells;
  it->second[static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x)] = value;
}

Tile encode_grid_tile(const TileKey& key, const TileCells& cells, double resolution_m,
                      std::int64_t revision, std::int64_t utime_us) {
  return tile_of_packed(TileEncoding::kGridProbability, key,
                        deflate_bytes(std::vector<std::uint8_t>(cells.begin(), cells.end())),
                        kTileCells, resolution_m, revision, utime_us);
}

std::optional<TileCells> decode_grid_tile(const Tile& tile) {
  TileCells cells;
  if (tile.encoding != TileEncoding::kGridProbability || tile.size_cells != kTileCells)
    return std::nullopt;
  const auto raw = inflate_bytes(tile.data.data(), tile.data.size(), cells.size());
  if (!raw || raw->size() != cells.size()) return std::nullopt;
  std::copy(raw->begin(), raw->end(), cells.begin());
  return cells;
}

}  // namespace fusion_slam
