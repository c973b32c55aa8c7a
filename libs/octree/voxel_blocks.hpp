// A sparse 3D grid of log-odds, kept as blocks of 16 x 16 x 16 voxels. Voxel (i, j, k) covers [i,
// i+1) x [j, j+1) x [k, k+1) times resolution_m. Values are sums of log-odds steps (kLogOddsStep of
// octomap_tile.hpp): integers, so that the order in which observations are added does not matter
// (equation 4 of the paper).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <tuple>

namespace fusion_slam {

constexpr int kBlockVoxels = 16;
constexpr int kBlockVolume = kBlockVoxels * kBlockVoxels * kBlockVoxels;
constexpr std::int16_t kUnknownLogOdds = INT16_MIN;

struct BlockIndex {  // floor(voxel / 16)
  int x = 0;
  int y = 0;
  int z = 0;

  bool operator<(const BlockIndex& other) const {
    return std::tie(x, y, z) < std::tie(other.x, other.y, other.z);
  }
  bool operator==(const BlockIndex& other) const {
    return x == other.x && y == other.y && z == other.z;
  }
};

using VoxelBlock = std::array<std::int16_t, kBlockVolume>;  // x fastest

class VoxelBlocks {
 public:
  // Shift and mask round towards minus infinity on every compiler this project supports.
  static BlockIndex block_of(int x, int y, int z) { return {x >> 4, y >> 4, z >> 4}; }
  static std::size_t offset_of(int x, int y, int z) {
    return static_cast<std::size_t>(((z & 15) << 8) | ((y & 15) << 4) | (x & 15));
  }

  std::int16_t at(int x, int y, int z) const;  // kUnknownLogOdds where nothing was added
  // Adds to a voxel (unknown counts as 0), saturating far beyond any clamping bound.
  void add(int x, int y, int z, int steps);

  const VoxelBlock* find(const BlockIndex& index) const;
  VoxelBlock& block(const BlockIndex& index);  // makes it when needed
  const std::map<BlockIndex, VoxelBlock>& blocks() const { return blocks_; }

 private:
  std::map<BlockIndex, VoxelBlock> blocks_;
};

// Sum of a voxel's steps and an observation, as VoxelBlocks::add does it.
std::int16_t add_steps(std::int16_t voxel, int steps);

// Reads neighbouring voxels fast: remembers the block of the last one.
class VoxelReader {
 public:
  explicit VoxelReader(const VoxelBlocks& voxels) : voxels_(&voxels) {}

  std::int16_t at(int x, int y, int z) {
    const BlockIndex index = VoxelBlocks::block_of(x, y, z);
    if (!valid_ || !(index == index_)) {
      index_ = index;
      block_ = voxels_->find(index);
      valid_ = true;
    }
    return block_ == nullptr ? kUnknownLogOdds : (*block_)[VoxelBlocks::offset_of(x, y, z)];
  }

 private:
  const VoxelBlocks* voxels_;
  const VoxelBlock* block_ = nullptr;
  BlockIndex index_;
  bool valid_ = false;
};

// Writes neighbouring voxels fast, likewise.
class VoxelWriter {
 public:
  explicit VoxelWriter(VoxelBlocks* voxels) : voxels_(voxels) {}

  std::int16_t& at(int x, int y, int z) {
    const BlockIndex index = VoxelBlocks::block_of(x, y, z);
    if (block_ == nullptr || !(index == index_)) {
      index_ = index;
      block_ = &voxels_->block(index);
    }
    return (*block_)[VoxelBlocks::offset_of(x, y, z)];
  }

 private:
  VoxelBlocks* voxels_;
  VoxelBlock* block_ = nullptr;
  BlockIndex index_;
};

}  // namespace fusion_slam
