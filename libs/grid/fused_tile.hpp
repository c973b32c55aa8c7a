// Tile of the fused grid (encoding kGridFused): what is there, and which sensor says so. Byte
// table: docs/tiles.md.
#pragma once

#include <cstdint>
#include <optional>

#include "libs/grid/tiled_grid.hpp"
#include "libs/tiles/tile.hpp"

namespace fusion_slam {

enum class Provenance : std::uint8_t {
  kNone = 0,  // neither sensor has seen the cell
  kLidar = 1,
  kCamera = 2,
  kBoth = 3,      // and they agree
  kConflict = 4,  // LiDAR says occupied, camera says the whole column is unoccupied
};

struct FusedCells {
  TileCells probability{};  // as in tiled_grid.hpp
  TileCells provenance{};   // values of Provenance

  bool operator==(const FusedCells& other) const {
    return probability == other.probability && provenance == other.provenance;
  }
};

// Decoding gives nothing when the tile is not what encode_fused_tile makes (encoding, size, damaged
// data, a provenance that does not exist). Never throws on any bytes.
Tile encode_fused_tile(const TileKey& key, const FusedCells& cells, double resolution_m,
                       std::int64_t revision, std::int64_t utime_us);
std::optional<FusedCells> decode_fused_tile(const Tile& tile);

}  // namespace fusion_slam
