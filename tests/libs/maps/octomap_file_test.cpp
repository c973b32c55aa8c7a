#include "libs/maps/octomap_file.hpp"

#include <limits>
#include <memory>
#include <random>
#include <sstream>

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

TEST(OctomapFile, OctomapReadsItAgain) {
  std::mt19937 rng(3);
  std::map<TileKey, Tile> tiles;
  for (const TileKey& key : {TileKey{0, 0, 0, 0}, TileKey{0, -1, 2, -3}}) {
    VoxelCells cells;
    cells.fill(kUnknownVoxel);
    for (int n = 0; n < 3000; ++n)
      cells[rng() % cells.size()] = static_cast<std::int8_t>(rng() % 2 == 0 ? 60 : -40);
    tiles[key] = encode_octomap_tile(key, cells, 0.05, 1, 0);
  }
  std::string why;
  const auto bytes = octomap_bt_bytes(tiles, &why);
  ASSERT_TRUE(bytes) << why;
  EXPECT_EQ(bytes, octomap_bt_bytes(tiles, &why));

  octomap::OcTree tree(1.0);
  std::istringstream in(*bytes);
  ASSERT_EQ(bytes->rfind("# Octomap OcTree binary file\n", 0), 0U);
  ASSERT_TRUE(tree.readBinary(in));
  EXPECT_DOUBLE_EQ(tree.getResolution(), 0.05);
  std::size_t known = 0;
  for (const auto& [key, tile] : tiles) {
    const auto voxels = decode_octomap_tile(tile);
    ASSERT_TRUE(voxels);
    for (const OctomapVoxel& voxel : *voxels) {
      const Eigen::Vector3d p = voxel_centre_m(tile, voxel);
      const auto* node = tree.search(p.x(), p.y(), p.z());
      ASSERT_NE(node, nullptr);
      EXPECT_EQ(tree.isNodeOccupied(node), voxel.log_odds > 0.0F);
      ++known;
    }
  }
  std::size_t volume = 0;  // of all leaves, in voxels
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const auto edge = static_cast<std::size_t>(std::lround(leaf.getSize() / 0.05));
    volume += edge * edge * edge;
  }
  EXPECT_EQ(volume, known);
}

TEST(OctomapFile, TheFullTreeKeepsItsLogOdds) {
  VoxelCells cells;
  cells.fill(kUnknownVoxel);
  cells[5] = 60;
  cells[6] = -40;
  cells[7] = 12;
  const TileKey key{0, -1, 2, -3};
  const std::map<TileKey, Tile> tiles{{key, encode_octomap_tile(key, cells, 0.05, 1, 0)}};
  std::string why;
  const auto bytes = octomap_ot_bytes(tiles, &why);
  ASSERT_TRUE(bytes) << why;
  EXPECT_EQ(*bytes, golden("three_voxels.ot"));
  std::istringstream in(*bytes);
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(in));
  const auto* tree = dynamic_cast<const octomap::OcTree*>(read.get());
  ASSERT_NE(tree, nullptr);
  EXPECT_DOUBLE_EQ(tree->getResolution(), 0.05);
  const auto voxels = decode_octomap_tile(tiles.at(key));
  ASSERT_TRUE(voxels);
  ASSERT_EQ(voxels->size(), 3U);
  for (const OctomapVoxel& voxel : *voxels) {
    const Eigen::Vector3d p = voxel_centre_m(tiles.at(key), voxel);
    const auto* node = tree->search(p.x(), p.y(), p.z());
    ASSERT_NE(node, nullptr);
    EXPECT_FLOAT_EQ(node->getLogOdds(), voxel.log_odds);
  }
  EXPECT_FALSE(octomap_ot_bytes({}, &why));
}

TEST(OctomapFile, NothingKnownHasAReason) {
  std::string why;
  EXPECT_FALSE(octomap_bt_bytes({}, &why));
  EXPECT_EQ(why, "no voxel of the map is known");
  Tile damaged;
  damaged.encoding = TileEncoding::kOctomap;
  damaged.data = {1, 2, 3};
  EXPECT_FALSE(octomap_bt_bytes({{TileKey{}, damaged}}, &why));
}

TEST(OctomapFile, KeepsItsKeyRangeToTheLastVoxel) {
  VoxelCells cells;
  cells.fill(kUnknownVoxel);
  cells[0] = 60;
  std::map<TileKey, Tile> tiles;
  for (const int x : {-1024, 1023, -1025, 1024, std::numeric_limits<int>::min()}) {
    const TileKey key{0, x, 0, 0};
    tiles[key] = encode_octomap_tile(key, cells, 0.05, 1, 0);
  }
  std::string why;
  const auto bytes = octomap_bt_bytes(tiles, &why);
  ASSERT_TRUE(bytes) << why;
  octomap::OcTree tree(1.0);
  std::istringstream in(*bytes);
  ASSERT_TRUE(tree.readBinary(in));
  EXPECT_EQ(tree.getNumLeafNodes(), 2U);  // the first and the last are in range
}

}  // namespace
}  // namespace fusion_slam
