#include "services/dense_mapper/compose.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "libs/octree/octomap_tile.hpp"

namespace fusion_slam {
namespace {

constexpr double kResolution = 0.05;

DenseSubmaps random_submaps() {
  std::mt19937 random(6);
  DenseSubmaps submaps;
  for (int id = 1; id <= 3; ++id) {
    DenseSubmap& submap = submaps.emplace(id, DenseSubmap(0.025)).first->second;
    for (int i = 0; i < 20000; ++i)
      submap.voxels.add(static_cast<int>(random() % 40) - 20, static_cast<int>(random() % 40) - 20,
                        static_cast<int>(random() % 40) - 20,
                        static_cast<int>(random() % 200) - 100);
    submap.T_map_submap = from_xyz_rpy(0.2 * id, -0.1 * id, 0.05, 0.3 * id, 0.1, 0.7 * id);
  }
  return submaps;
}

TEST(Compose, EqualsLookingUpEachVoxelAlone) {
  const DenseSubmaps submaps = random_submaps();
  const DenseMapperConfig config;
  LatticeBox box;
  box.low_m = Eigen::Vector3d(-1.0, -0.8, -0.6);
  box.size = {40, 30, 20};
  const auto fast = compose_voxels(submaps, box, config);
  std::size_t known = 0;
  std::size_t different = 0;
  for (int z = 0; z < 20; ++z)
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) {
        int sum = 0;
        bool seen = false;
        for (const auto& [id, submap] : submaps) {
          const Eigen::Vector3d centre =
              box.low_m + Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * kResolution;
          const Eigen::Vector3d p = submap.T_map_submap.inverse() * centre / kResolution;
          const int steps = submap.voxels.at(static_cast<int>(std::floor(p.x())),
                                             static_cast<int>(std::floor(p.y())),
                                             static_cast<int>(std::floor(p.z())));
          if (steps == kUnknownLogOdds) continue;
          sum += std::clamp(steps, -64, 112);
          seen = true;
        }
        const int expected = seen ? std::clamp(sum, -64, 112) : kUnknownVoxel;
        known += seen ? 1 : 0;
        different += fast[static_cast<std::size_t>((z * 30 + y) * 40 + x)] == expected ? 0 : 1;
      }
  EXPECT_GT(known, 5000U);
  EXPECT_LE(different, 2U);  // a centre on a face may round to either side
}

TEST(Compose, BlocksTouchTheTilesOfTheirVoxels) {
  const SE3 T = from_xyz_rpy(0.3, -2.0, 1.0, 0.4, 0.2, 1.0);
  const BlockIndex block{-2, 1, 0};
  const TileRange range = tiles_of_block(block, kResolution, T, 1.6);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(0.0, 0.8);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p = Eigen::Vector3d(-1.6, 0.8, 0.0) +
                              Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
    const Eigen::Array3i tile = ((T * p) / 1.6).array().floor().cast<int>();
    EXPECT_TRUE((tile >= range.low.array()).all() && (tile <= range.high.array()).all());
  }
}

TEST(Compose, CloudPointsGoToTheirTiles) {
  DenseSubmaps submaps;
  DenseSubmap& submap = submaps.emplace(1, DenseSubmap(0.025)).first->second;
  ColouredPoint point;
  point.p_m = {0.1F, 0.1F, 0.1F};
  submap.cloud.add({point});
  submap.T_map_submap.translation() = Eigen::Vector3d(1.0, 0.0, 0.0);
  EXPECT_TRUE(compose_cloud(submaps, {{0, 0, 0, 0}}, 0.025).empty());
  const auto tiles = compose_cloud(submaps, {{0, 0, 0, 0}, {0, 1, 0, 0}}, 0.025);
  ASSERT_EQ(tiles.size(), 1U);
  EXPECT_NEAR(tiles.at({0, 1, 0, 0}).at(0).p_m.x(), 1.1F, 1e-4);
}

}  // namespace
}  // namespace fusion_slam
