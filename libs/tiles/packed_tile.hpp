// A tile around content that is packed already, as all kinds of tiles have it. Pure function.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/tiles/tile.hpp"

namespace fusion_slam {

// Edge size_cells (cells or voxels) of resolution_m. No bytes make an empty tile, whatever the
// encoding.
Tile tile_of_packed(TileEncoding encoding, const TileKey& key, std::vector<std::uint8_t> packed,
                    std::int32_t size_cells, double resolution_m, std::int64_t revision,
                    std::int64_t utime_us);

}  // namespace fusion_slam
