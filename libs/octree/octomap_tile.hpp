// Tile of an OctoMap (encoding kOctomap): a cube of 32 x 32 x 32 voxels with one log-odds each.
// Byte table: docs/tiles.md. Voxel (i, j, k) of the map covers [i, i+1) x [j, j+1) x [k, k+1) times
// resolution_m and lies in tile floor(i / 32) ... A tile never has more than 36,864 bytes before
// compression.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "libs/tiles/tile.hpp"

namespace fusion_slam {

constexpr int kOctomapTileVoxels = 32;
constexpr int kOctomapTileVolume = kOctomapTileVoxels * kOctomapTileVoxels * kOctomapTileVoxels;
constexpr std::int8_t kUnknownVoxel = -128;
constexpr double kLogOddsStep = 1.0 / 32.0;  // the clamping bounds -2 and 3.5 are whole steps

// Log-odds of each voxel in steps, x fastest: [(z * 32 + y) * 32 + x].
using VoxelCells = std::array<std::int8_t, kOctomapTileVolume>;

inline std::size_t voxel_index(int x, int y, int z) {
  constexpr auto n = static_cast<std::size_t>(kOctomapTileVoxels);
  return (static_cast<std::size_t>(z) * n + static_cast<std::size_t>(y)) * n +
         static_cast<std::size_t>(x);
}

struct OctomapVoxel {
  std::uint8_t x = 0;  // within the tile, 0..31
  std::uint8_t y = 0;
  std::uint8_t z = 0;
  float log_odds = 0.0F;  // ln(p / (1 - p)), equation 3 of the paper
};

// Log-odds to steps, saturated at +-127.
std::int8_t log_odds_to_step(double log_odds);

// A tile without any known voxel becomes an empty one (encoding kEmpty). Decoding gives nothing
// when the tile is not what encode_octomap_tile makes; an empty tile decodes to no voxels. Never
// throws on any bytes.
Tile encode_octomap_tile(const TileKey& key, const VoxelCells& cells, double resolution_m,
                         std::int64_t revision, std::int64_t utime_us);
// The same from what pack_cells() (voxel_pack.hpp) made; no bytes make an empty tile.
Tile octomap_tile_of(const TileKey& key, std::vector<std::uint8_t> packed, double resolution_m,
                     std::int64_t revision, std::int64_t utime_us);
std::optional<VoxelCells> decode_octomap_cells(const Tile& tile);
std::optional<std::vector<OctomapVoxel>> decode_octomap_tile(
    const Tile& tile);  // known voxels only

// Centre of a tile's voxel in the tile's frame (the map's for submap 0), metres.
Eigen::Vector3d voxel_centre_m(const Tile& tile, const OctomapVoxel& voxel);

}  // namespace fusion_slam
