#include "services/dense_mapper/dense_submap.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "libs/octree/octomap_tile.hpp"

namespace fusion_slam {
namespace {

constexpr double kResolution = 0.05;

DepthCloud one_point(float x, float y, float z) {
  DepthCloud cloud;
  ColouredPoint p;
  p.p_m = {x, y, z};
  cloud.points = {p};
  cloud.sparse = {0};
  return cloud;
}

TEST(DenseSubmap, HitsSayLessTheFartherTheyAre) {
  CameraModel camera;
  const DenseMapperConfig config;
  const int near = hit_steps(0.5, camera, kResolution, config);
  EXPECT_NEAR(near * kLogOddsStep, std::log(0.7 / 0.3), kLogOddsStep);
  EXPECT_LT(hit_steps(5.0, camera, kResolution, config), near / 2);
  EXPECT_GT(hit_steps(5.0, camera, kResolution, config), 0);
  EXPECT_NEAR(miss_steps(config) * kLogOddsStep, std::log(0.4 / 0.6), kLogOddsStep);
}

TEST(DenseSubmap, RayFreesUntilItsEnd) {
  const CameraModel camera;
  const DenseMapperConfig config;
  DenseSubmap submap(0.025);
  // Camera at the origin looks along z; the point lies in the middle of voxel (0, 0, 20).
  const auto blocks = integrate_cloud(one_point(0.025F, 0.025F, 1.025F), SE3::Identity(), camera,
                                      kResolution, config, true, &submap);
  EXPECT_EQ(submap.voxels.at(0, 0, 20), hit_steps(1.025, camera, kResolution, config));
  for (int z = 1; z < 19; ++z) EXPECT_EQ(submap.voxels.at(0, 0, z), miss_steps(config)) << z;
  EXPECT_EQ(submap.voxels.at(0, 0, 21), kUnknownLogOdds);
  EXPECT_EQ(submap.voxels.at(1, 0, 10), kUnknownLogOdds);
  EXPECT_EQ(blocks.count({0, 0, 1}), 1U);
  EXPECT_EQ(submap.cloud.size(), 1U);
}

TEST(DenseSubmap, AVoxelCountsOnceAKeyframeAndHitsWin) {
  const CameraModel camera;
  const DenseMapperConfig config;
  DepthCloud cloud = one_point(0.02F, 0.02F, 1.01F);
  for (const float z : {1.02F, 1.03F, 2.0F})
    cloud.points.push_back(one_point(0.02F, 0.02F, z).points[0]);
  DenseSubmap submap(0.025);
  integrate_cloud(cloud, SE3::Identity(), camera, kResolution, config, true, &submap);
  EXPECT_EQ(submap.voxels.at(0, 0, 20), hit_steps(1.01, camera, kResolution, config));
  integrate_cloud(cloud, SE3::Identity(), camera, kResolution, config, true,
                  &submap);  // equation 4
  EXPECT_EQ(submap.voxels.at(0, 0, 20), 2 * hit_steps(1.01, camera, kResolution, config));
}

}  // namespace
}  // namespace fusion_slam
