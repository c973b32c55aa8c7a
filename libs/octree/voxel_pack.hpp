// Cubes of 32 x 32 x 32 log-odds, as they are worked with and as they are kept: deflated, because
// most of a finished map is uniform free space (about 1 KB instead of 32 KB a cube).
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "libs/octree/octomap_tile.hpp"
#include "libs/octree/voxel_blocks.hpp"

namespace fusion_slam {

using PackedBytes = std::vector<std::uint8_t>;

// Bit mask of the known voxels, then one int8 for each of them, deflated: the content of an OCTOMAP
// tile (docs/tiles.md). No known voxel gives no bytes.
PackedBytes pack_cells(const VoxelCells& cells);
// The inverse; no bytes are all unknown. False: not what pack_cells makes (cells are then
// unspecified). Never throws on any bytes.
bool unpack_cells(const PackedBytes& bytes, VoxelCells* cells);

// Cubes by index: cube (i, j, k) holds voxels [32 i, 32 i + 32) x ...
struct CubeIndex {
  int x = 0;
  int y = 0;
  int z = 0;

  bool operator<(const CubeIndex& other) const {
    return std::tie(x, y, z) < std::tie(other.x, other.y, other.z);
  }
  bool operator==(const CubeIndex& other) const {
    return x == other.x && y == other.y && z == other.z;
  }
};
using PackedCubes = std::map<CubeIndex, PackedBytes>;
using VoxelCubes = std::map<CubeIndex, std::unique_ptr<VoxelCells>>;  // never null

CubeIndex cube_of(const BlockIndex& block);  // the cube that a block of 16^3 lies in

// A new cube is all unknown.
VoxelCells& cube_at(VoxelCubes* cubes, const CubeIndex& index);

// Copies a block of 16^3 sums into its cube, limited to [low, high].
void copy_block(const BlockIndex& index, const VoxelBlock& block, int low, int high,
                VoxelCubes* cubes);

PackedCubes pack_cubes(const VoxelCubes& cubes);  // cubes without a known voxel are left out
VoxelCubes unpack_cubes(const PackedCubes& packed);
std::size_t size_bytes(const PackedCubes& packed);

// OctoMap's clamping update (Hornung et al. 2013, equation 4 with bounds): `sum` is at once limited
// to [low, high], so that a few new observations always outweigh however many old ones. Unknown is
// 0 for the sum; adding unknown changes nothing.
inline std::int8_t add_clamped(std::int8_t sum, std::int8_t steps, int low, int high) {
  if (steps == kUnknownVoxel) return sum;
  const int both = (sum == kUnknownVoxel ? 0 : sum) + steps;
  return static_cast<std::int8_t>(both < low ? low : (both > high ? high : both));
}

}  // namespace fusion_slam
