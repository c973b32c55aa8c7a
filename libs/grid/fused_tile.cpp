#include "libs/grid/fused_tile.hpp"

#include <algorithm>

#include "libs/tiles/packed_tile.hpp"

namespace fusion_slam {

Tile encode_fused_tile(const TileKey& key, const FusedCells& cells, double resolution_m,
                       std::int64_t revision, std::int64_t utime_us) {
  std::vector<std::uint8_t> raw(cells.probability.begin(), cells.probability.end());
  raw.insert(raw.end(), cells.provenance.begin(), cells.provenance.end());
  return tile_of_packed(TileEncoding::kGridFused, key, deflate_bytes(raw), kTileCells, resolution_m,
                        revision, utime_us);
}

std::optional<FusedCells> decode_fused_tile(const Tile& tile) {
  if (tile.encoding != TileEncoding::kGridFused || tile.size_cells != kTileCells)
    return std::nullopt;
  FusedCells cells;
  const std::size_t n = cells.probability.size();
  const auto raw = inflate_bytes(tile.data.data(), tile.data.size(), 2 * n);
  if (!raw || raw->size() != 2 * n) return std::nullopt;
  const auto middle = raw->begin() + static_cast<std::ptrdiff_t>(n);
  std::copy(raw->begin(), middle, cells.probability.begin());
  std::copy(middle, raw->end(), cells.provenance.begin());
  const auto highest = static_cast<std::uint8_t>(Provenance::kConflict);
  for (const std::uint8_t provenance : cells.provenance)
    if (provenance > highest) return std::nullopt;
  return cells;
}

}  // namespace fusion_slam
