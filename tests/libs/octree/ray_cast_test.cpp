#include "libs/octree/ray_cast.hpp"

#include <array>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

using Voxel = std::array<int, 3>;

std::vector<Voxel> cast(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  std::vector<Voxel> voxels;
  cast_ray(from, to, [&](int x, int y, int z) { voxels.push_back({x, y, z}); });
  return voxels;
}

Voxel voxel_of(const Eigen::Vector3d& p) {
  return {static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
          static_cast<int>(std::floor(p.z()))};
}

TEST(CastRay, VisitsWhatFineSamplingFinds) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-12.0, 12.0);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d a(uniform(random), uniform(random), uniform(random));
    const Eigen::Vector3d b(uniform(random), uniform(random), uniform(random));
    const std::vector<Voxel> ray = cast(a, b);
    EXPECT_EQ(ray.front(), voxel_of(a));
    EXPECT_EQ(ray.back(), voxel_of(b));
    const std::set<Voxel> visited(ray.begin(), ray.end());
    EXPECT_EQ(visited.size(), ray.size());  // none twice
    for (int i = 0; i <= 3000; ++i)
      ASSERT_EQ(visited.count(voxel_of(a + (b - a) * (i / 3000.0))), 1U);
    for (std::size_t i = 1; i < ray.size(); ++i) {  // from face to face
      int steps = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        steps += std::abs(ray[i][axis] - ray[i - 1][axis]);
      ASSERT_EQ(steps, 1);
    }
  }
}

TEST(CastRay, DegenerateRays) {
  EXPECT_EQ(cast({0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}).size(), 1U);
  EXPECT_EQ(cast({0.5, 0.5, 0.5}, {3.5, 0.5, 0.5}).size(), 4U);  // along an axis
  EXPECT_EQ(cast({0.0, 0.0, 0.0}, {-3.0, -3.0, 0.0}).size(),
            7U);  // through edges, from face to face
  EXPECT_EQ(cast({3.0, 0.0, 0.0}, {0.0, 0.0, 0.0}).size(), 4U);
}

}  // namespace
}  // namespace fusion_slam
