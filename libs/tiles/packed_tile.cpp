#include "libs/tiles/packed_tile.hpp"

#include <utility>

namespace fusion_slam {

Tile tile_of_packed(TileEncoding encoding, const TileKey& key, std::vector<std::uint8_t> packed,
                    std::int32_t size_cells, double resolution_m, std::int64_t revision,
                    std::int64_t utime_us) {
  Tile tile;
  tile.key = key;
  tile.utime_us = utime_us;
  tile.revision = revision;
  tile.resolution_m = resolution_m;
  tile.size_cells = size_cells;
  if (packed.empty()) return tile;
  tile.encoding = encoding;
  tile.data = std::move(packed);
  return tile;
}

}  // namespace fusion_slam
