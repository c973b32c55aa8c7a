#include "libs/octree/voxel_blocks.hpp"

#include <array>
#include <map>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(VoxelBlocks, BehavesLikeAMapOfVoxels) {
  std::mt19937 random(2);
  std::map<std::array<int, 3>, int> simple;
  VoxelBlocks voxels;
  const auto coordinate = [&random] { return static_cast<int>(random() % 80) - 40; };
  for (int i = 0; i < 5000; ++i) {
    const std::array<int, 3> v{coordinate(), coordinate(), coordinate()};
    const int steps = static_cast<int>(random() % 41) - 20;
    simple[v] += steps;
    voxels.add(v[0], v[1], v[2], steps);
  }
  VoxelReader reader(voxels);
  std::size_t known = 0;
  for (int z = -48; z < 48; ++z)
    for (int y = -48; y < 48; ++y)
      for (int x = -48; x < 48; ++x) {
        const auto it = simple.find({x, y, z});
        const int expected = it == simple.end() ? kUnknownLogOdds : it->second;
        known += it != simple.end() ? 1 : 0;
        ASSERT_EQ(voxels.at(x, y, z), expected);
        ASSERT_EQ(reader.at(x, y, z), expected);
      }
  EXPECT_EQ(known, simple.size());
}

TEST(VoxelBlocks, WriterMakesBlocksAndSumsSaturate) {
  VoxelBlocks voxels;
  VoxelWriter writer(&voxels);
  EXPECT_EQ(writer.at(-1, 0, 0), kUnknownLogOdds);
  writer.at(-1, 0, 0) = 5;
  writer.at(16, 0, 0) = 6;
  EXPECT_EQ(voxels.at(-1, 0, 0), 5);
  EXPECT_EQ(voxels.blocks().size(), 2U);
  std::int16_t sum = kUnknownLogOdds;
  for (int i = 0; i < 2000; ++i) sum = add_steps(sum, -100);
  EXPECT_EQ(sum, -30000);
  EXPECT_GT(sum, kUnknownLogOdds);
}

}  // namespace
}  // namespace fusion_slam
