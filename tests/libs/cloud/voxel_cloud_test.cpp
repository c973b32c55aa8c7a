#include "libs/cloud/voxel_cloud.hpp"

#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

ColouredPoint point(float x, float y, float z, std::uint8_t grey) {
  ColouredPoint p;
  p.p_m = {x, y, z};
  p.r = p.g = p.b = grey;
  return p;
}

TEST(VoxelCloud, OneMeanPointAVoxel) {
  VoxelCloud cloud(0.1);
  cloud.add({point(0.02F, 0.05F, 0.05F, 10), point(-0.05F, 0.05F, 0.05F, 7)});
  cloud.add({point(0.04F, 0.05F, 0.05F, 20)});
  const auto points = cloud.points();
  ASSERT_EQ(points.size(), 2U);
  EXPECT_NEAR(points[0].p_m.x(), -0.05F, 2e-4);
  EXPECT_NEAR(points[1].p_m.x(), 0.03F, 2e-4);
  EXPECT_EQ(points[1].r, 15);
}

TEST(VoxelCloud, OrderDoesNotMatterAndBadPointsAreLeftOut) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  std::vector<ColouredPoint> points;
  for (int i = 0; i < 3000; ++i)
    points.push_back(point(uniform(random), uniform(random), uniform(random),
                           static_cast<std::uint8_t>(random())));
  points.push_back(point(std::numeric_limits<float>::quiet_NaN(), 0, 0, 1));
  VoxelCloud at_once(0.25);
  at_once.add(points);
  std::shuffle(points.begin(), points.end(), random);
  VoxelCloud piecewise(0.25);
  for (std::size_t i = 0; i < points.size(); i += 100)
    piecewise.add({points.begin() + static_cast<std::ptrdiff_t>(i),
                   points.begin() + static_cast<std::ptrdiff_t>(std::min(i + 100, points.size()))});
  const auto a = at_once.points();
  const auto b = piecewise.points();
  ASSERT_EQ(a.size(), b.size());
  EXPECT_LE(a.size(), 512U);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].p_m, b[i].p_m);
    EXPECT_EQ(a[i].r, b[i].r);
  }
}

}  // namespace
}  // namespace fusion_slam
