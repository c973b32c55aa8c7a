#include "services/lidar_mapper/surface_fill.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

// A wall at y = 1, seen at 1 degree: the far beams are wide apart.
TEST(FillSurfaces, AWallIsClosedAndALeapIsNot) {
  const double step = M_PI / 180.0;
  Points wall;
  for (int i = 15; i <= 90; ++i) wall.emplace_back(1.0 / std::tan(i * step), 1.0);
  const Points filled = fill_surfaces(wall, {0, 0}, step, 0.035, 0.01);
  EXPECT_GT(filled.size(), 50U);
  for (const auto& p : filled) EXPECT_NEAR(p.y(), 1.0, 1e-9);

  Points leap;  // a post in front of a wall
  for (int i = 60; i <= 75; ++i) leap.emplace_back(3.0 / std::tan(i * step), 3.0);
  for (int i = 76; i <= 90; ++i) leap.emplace_back(2.5 / std::tan(i * step), 2.5);
  for (const auto& p : fill_surfaces(leap, {0, 0}, step, 0.035, 0.01))
    EXPECT_TRUE(std::abs(p.y() - 3.0) < 1e-9 || std::abs(p.y() - 2.5) < 1e-9) << p.transpose();
}

}  // namespace
}  // namespace fusion_slam
