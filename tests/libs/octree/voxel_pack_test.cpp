#include "libs/octree/voxel_pack.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

VoxelCells random_cells(unsigned seed, unsigned one_in) {
  std::mt19937 random(seed);
  VoxelCells cells;
  for (auto& cell : cells)
    cell = random() % one_in == 0 ? static_cast<std::int8_t>(static_cast<int>(random() % 255) - 127)
                                  : kUnknownVoxel;
  return cells;
}

TEST(VoxelPack, ComesBackAsItWas) {
  for (const unsigned one_in : {1U, 3U, 1000U}) {
    const VoxelCells cells = random_cells(one_in, one_in);
    VoxelCells back;
    ASSERT_TRUE(unpack_cells(pack_cells(cells), &back));
    EXPECT_TRUE(back == cells);
  }
}

TEST(VoxelPack, NothingKnownTakesNoBytes) {
  VoxelCells cells;
  cells.fill(kUnknownVoxel);
  EXPECT_TRUE(pack_cells(cells).empty());
  VoxelCells back = random_cells(1, 2);
  EXPECT_TRUE(unpack_cells({}, &back));
  EXPECT_TRUE(back == cells);
}

TEST(VoxelPack, IsTheContentOfAnOctomapTile) {
  const VoxelCells cells = random_cells(4, 5);
  EXPECT_EQ(encode_octomap_tile({0, 1, 2, 3}, cells, 0.05, 7, 9).data, pack_cells(cells));
}

TEST(VoxelPack, DamagedBytesAreRefused) {
  const PackedBytes good = pack_cells(random_cells(4, 5));
  VoxelCells cells;
  std::mt19937 random(2);
  for (int i = 0; i < 50; ++i) {
    PackedBytes bad = good;
    bad.resize(random() % bad.size());
    EXPECT_EQ(unpack_cells(bad, &cells), bad.empty());
  }
  EXPECT_FALSE(unpack_cells(deflate_bytes(PackedBytes(4096, 255)), &cells));  // mask without values
}

TEST(VoxelPack, BlocksLandInTheirCubesWithinTheBounds) {
  VoxelBlocks blocks;
  std::mt19937 random(3);
  for (int i = 0; i < 3000; ++i)
    blocks.add(static_cast<int>(random() % 90) - 45, static_cast<int>(random() % 90) - 45,
               static_cast<int>(random() % 90) - 45, static_cast<int>(random() % 400) - 200);
  VoxelCubes cubes;
  for (const auto& [index, block] : blocks.blocks()) copy_block(index, block, -64, 112, &cubes);
  const VoxelCubes back = unpack_cubes(pack_cubes(cubes));
  for (int z = -45; z < 45; ++z)
    for (int y = -45; y < 45; ++y)
      for (int x = -45; x < 45; ++x) {
        const int sum = blocks.at(x, y, z);
        const auto cube = back.find({x >> 5, y >> 5, z >> 5});
        const int is = cube == back.end() ? kUnknownVoxel
                                          : (*cube->second)[voxel_index(x & 31, y & 31, z & 31)];
        ASSERT_EQ(is, sum == kUnknownLogOdds ? kUnknownVoxel : std::clamp(sum, -64, 112));
      }
}

TEST(VoxelPack, ClampedSumsForget) {
  std::int8_t sum = kUnknownVoxel;
  for (int i = 0; i < 100; ++i) sum = add_clamped(sum, 100, -64, 112);
  EXPECT_EQ(sum, 112);
  sum = add_clamped(sum, -64, -64, 112);
  sum = add_clamped(sum, kUnknownVoxel, -64, 112);
  EXPECT_EQ(add_clamped(sum, -64, -64, 112), -16);  // two against a hundred
}

}  // namespace
}  // namespace fusion_slam
