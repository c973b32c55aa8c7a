#include "libs/octree/octomap_tile.hpp"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/damaged_tile.hpp"

namespace fusion_slam {
namespace {

VoxelCells example() {
  VoxelCells cells;
  cells.fill(kUnknownVoxel);
  cells[voxel_index(0, 0, 0)] = log_odds_to_step(3.5);
  cells[voxel_index(31, 2, 1)] = log_odds_to_step(-2.0);
  return cells;
}

TEST(OctomapTile, BytesAreThoseOfTheTable) {
  const Tile tile = encode_octomap_tile({0, 1, -1, 0}, example(), 0.05, 4, 9);
  EXPECT_EQ(tile.encoding, TileEncoding::kOctomap);
  EXPECT_EQ(tile.size_cells, 32);
  const auto raw = inflate_bytes(tile.data.data(), tile.data.size(), 100000);
  ASSERT_TRUE(raw);
  std::vector<std::uint8_t> golden(4096, 0);
  golden[0] = 0x01;
  const std::size_t bit = (1 * 32 + 2) * 32 + 31;
  golden[bit / 8] = 0x80;
  golden.push_back(112);       // 3.5 * 32
  golden.push_back(256 - 64);  // -2 * 32
  EXPECT_EQ(*raw, golden);
}

TEST(OctomapTile, VoxelsSurviveTheWire) {
  const Tile tile = encode_octomap_tile({0, 1, -1, 0}, example(), 0.05, 4, 9);
  const auto voxels = decode_octomap_tile(tile);
  ASSERT_TRUE(voxels);
  ASSERT_EQ(voxels->size(), 2U);
  EXPECT_EQ((*voxels)[0].log_odds, 3.5F);
  EXPECT_EQ((*voxels)[1].x, 31);
  EXPECT_EQ((*voxels)[1].y, 2);
  EXPECT_EQ((*voxels)[1].z, 1);
  EXPECT_EQ((*voxels)[1].log_odds, -2.0F);
  const Eigen::Vector3d centre = voxel_centre_m(tile, (*voxels)[1]);
  EXPECT_NEAR(centre.x(), 63.5 * 0.05, 1e-12);
  EXPECT_NEAR(centre.y(), -29.5 * 0.05, 1e-12);
  EXPECT_NEAR(centre.z(), 1.5 * 0.05, 1e-12);
}

TEST(OctomapTile, NothingKnownIsAnEmptyTile) {
  VoxelCells cells;
  cells.fill(kUnknownVoxel);
  const Tile tile = encode_octomap_tile({}, cells, 0.05, 1, 1);
  EXPECT_EQ(tile.encoding, TileEncoding::kEmpty);
  EXPECT_TRUE(tile.data.empty());
  const auto voxels = decode_octomap_tile(tile);
  ASSERT_TRUE(voxels);
  EXPECT_TRUE(voxels->empty());
}

TEST(OctomapTile, WorstCaseFitsADatagram) {
  VoxelCells cells;
  std::mt19937 random(7);
  for (auto& cell : cells) cell = static_cast<std::int8_t>(static_cast<int>(random() % 255) - 127);
  const Tile tile = encode_octomap_tile({}, cells, 0.05, 1, 1);
  EXPECT_LT(tile.data.size(), 50000U);
  const auto back = decode_octomap_cells(tile);
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, cells);
}

TEST(OctomapTile, DamageGivesNothing) {
  const Tile tile = encode_octomap_tile({}, example(), 0.05, 1, 1);
  expect_damage_is_noticed(tile, [](const Tile& t) { return decode_octomap_tile(t); });
  Tile wrong = tile;
  wrong.data = deflate_bytes(std::vector<std::uint8_t>(4096, 0xFF));  // mask without values
  EXPECT_FALSE(decode_octomap_tile(wrong));
  wrong.data = deflate_bytes(std::vector<std::uint8_t>(4097, 0));  // value without a mask bit
  EXPECT_FALSE(decode_octomap_tile(wrong));
  wrong.size_cells = 64;
  EXPECT_FALSE(decode_octomap_tile(wrong));
}

}  // namespace
}  // namespace fusion_slam
