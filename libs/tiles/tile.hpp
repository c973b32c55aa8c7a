// A tile: one numbered piece of a large map, small enough for a datagram. Plain data; libs/messages
// turns it into tile_t.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace fusion_slam {

// Which tile of which submap; submap 0 is the global map.
struct TileKey {
  std::int64_t submap_id = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  bool operator<(const TileKey& other) const {
    return std::tie(submap_id, x, y, z) < std::tie(other.submap_id, other.x, other.y, other.z);
  }
  bool operator==(const TileKey& other) const {
    return submap_id == other.submap_id && x == other.x && y == other.y && z == other.z;
  }
};

// Values are tile_t's constants.
enum class TileEncoding : std::int8_t {
  kEmpty = 0,
  kGridProbability = 1,
  kGridFused = 2,
  kOctomap = 3,
  kCloud = 4,
};

struct Tile {
  TileKey key;
  std::int64_t utime_us = 0;
  std::int64_t revision = 0;
  double resolution_m = 0.05;
  std::int32_t size_cells = 64;
  TileEncoding encoding = TileEncoding::kEmpty;
  std::vector<std::uint8_t> data;  // deflated
};

// zlib, fastest level: byte-identical for equal input. Empty in, empty out.
std::vector<std::uint8_t> deflate_bytes(const std::vector<std::uint8_t>& raw);

// The inverse; nothing when the data is damaged or would be larger than max_size_bytes.
std::optional<std::vector<std::uint8_t>> inflate_bytes(const std::uint8_t* data, std::size_t size,
                                                       std::size_t max_size_bytes);

}  // namespace fusion_slam
