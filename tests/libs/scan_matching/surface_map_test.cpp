#include "libs/scan_matching/surface_map.hpp"

#include <random>

#include <gtest/gtest.h>

#include "libs/scan_matching/surface_normals.hpp"
#include "tests/libs/scan_matching/drawn_room.hpp"

namespace fusion_slam {
namespace {

TEST(SurfaceNormals, AreTheWallsOwnAndFaceTheScanner) {
  const SE2 T{0.4, -0.3, 0.5};
  const Points points = room_sweep(T, {}, 0.0, 0.005, 1).points;
  const Points normals = surface_normals(points, {0, 0});
  ASSERT_EQ(normals.size(), points.size());
  int with = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (normals[i].isZero()) continue;
    ++with;
    EXPECT_NEAR(normals[i].norm(), 1.0, 1e-9);
    EXPECT_LT(normals[i].dot(points[i]), 0.0);
    const Eigen::Vector2d in_room = Eigen::Rotation2Dd(T.yaw) * normals[i];
    // All walls of the room are parallel to an axis.
    EXPECT_LT(std::min(std::abs(in_room.x()), std::abs(in_room.y())), 0.25);
  }
  EXPECT_GT(with, 280);
}

TEST(SurfaceNormals, CornersAndLonePointsHaveNone) {
  EXPECT_TRUE(surface_normals({}, {0, 0}).empty());
  EXPECT_TRUE(surface_normals({{1, 0}}, {0, 0})[0].isZero());
  Points corner;
  for (int i = 10; i >= 0; --i) corner.emplace_back(2.0 - 0.1 * i, 1.0);
  for (int i = 1; i <= 10; ++i) corner.emplace_back(2.0, 1.0 - 0.1 * i);
  const Points normals = surface_normals(corner, {0, 0});
  EXPECT_TRUE(normals[10].isZero());
  EXPECT_FALSE(normals[5].isZero());
  EXPECT_NEAR(normals[5].y(), -1.0, 1e-9);
}

// The nearest with the right side, as trying all finds it.
TEST(SurfaceMap, FindsWhatTryingAllFinds) {
  std::mt19937 rng(2);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  SurfaceMap map(0.1);
  std::vector<Surface> all;  // one a point: each is alone in its square
  Points points, normals;
  for (int x = -8; x <= 8; ++x)
    for (int y = -8; y <= 8; ++y) {
      if ((x + y) % 2 == 0) continue;
      points.emplace_back(0.1 * (x + 0.5 + 0.4 * u(rng)), 0.1 * (y + 0.5 + 0.4 * u(rng)));
      normals.push_back(Eigen::Rotation2Dd(M_PI * u(rng)) * Eigen::Vector2d(1, 0));
      all.push_back({points.back(), normals.back(), 1});
    }
  map.add(points, normals);
  EXPECT_EQ(map.size(), all.size());
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d q(0.7 * u(rng), 0.7 * u(rng));
    const Eigen::Vector2d n = Eigen::Rotation2Dd(M_PI * u(rng)) * Eigen::Vector2d(1, 0);
    const auto cell = [](double v) { return static_cast<int>(std::floor(v / 0.1)); };
    double nearest = 1e9;
    for (const Surface& s : all)
      if (std::abs(cell(s.point.x()) - cell(q.x())) <= 1 &&
          std::abs(cell(s.point.y()) - cell(q.y())) <= 1 && s.normal.dot(n) >= 0.7)
        nearest = std::min(nearest, (s.point - q).norm());
    const Surface* found = map.find(q, n);
    ASSERT_EQ(found != nullptr, nearest < 1e8);
    if (found != nullptr) {
      EXPECT_NEAR((found->point - q).norm(), nearest, 1e-12);
    }
  }
}

TEST(SurfaceMap, AveragesNoiseAwayAndKeepsTheSidesOfAThinWallApart) {
  std::mt19937 rng(3);
  std::normal_distribution<double> noise(0.0, 0.01);
  SurfaceMap map(0.1);
  for (int scan = 0; scan < 50; ++scan) {
    map.add({{1.04 + noise(rng), 0.55}, {1.07 + noise(rng), 0.55}}, {{-1, 0}, {1, 0}});
  }
  const Surface* near = map.find({1.0, 0.55}, {-1, 0});
  const Surface* far = map.find({1.0, 0.55}, {1, 0});
  ASSERT_TRUE(near != nullptr && far != nullptr);
  EXPECT_NEAR(near->point.x(), 1.04, 0.006);
  EXPECT_NEAR(far->point.x(), 1.07, 0.006);
  EXPECT_EQ(map.find({1.0, 0.55}, {0, 1}), nullptr);
  EXPECT_EQ(map.find({3.0, 0.55}, {1, 0}), nullptr);
  EXPECT_EQ(SurfaceMap(0.1).find({0, 0}, {1, 0}), nullptr);
}

}  // namespace
}  // namespace fusion_slam
