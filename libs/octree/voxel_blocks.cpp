#include "libs/octree/voxel_blocks.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

constexpr int kLargestSum = 30000;

}  // namespace

std::int16_t add_steps(std::int16_t voxel, int steps) {
  const int sum = (voxel == kUnknownLogOdds ? 0 : voxel) + steps;
  return static_cast<std::int16_t>(std::clamp(sum, -kLargestSum, kLargestSum));
}

const VoxelBlock* VoxelBlocks::find(const BlockIndex& index) const {
  const auto it = blocks_.find(index);
  return it == blocks_.end() ? nullptr : &it->second;
}

VoxelBlock& VoxelBlocks::block(const BlockIndex& index) {
  const auto [it, made] = blocks_.try_emplace(index);
  if (made) it->second.fill(kUnknownLogOdds);
  return it->second;
}

std::int16_t VoxelBlocks::at(int x, int y, int z) const {
  const VoxelBlock* found = find(block_of(x, y, z));
  return found == nullptr ? kUnknownLogOdds : (*found)[offset_of(x, y, z)];
}

void VoxelBlocks::add(int x, int y, int z, int steps) {
  std::int16_t& voxel = block(block_of(x, y, z))[offset_of(x, y, z)];
  voxel = add_steps(voxel, steps);
}

}  // namespace fusion_slam
