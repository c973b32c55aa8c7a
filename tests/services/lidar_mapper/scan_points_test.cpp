#include "services/lidar_mapper/scan_points.hpp"

#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "services/lidar_mapper/voxel_filter.hpp"
#include "tests/services/lidar_mapper/flat_world.hpp"

namespace fusion_slam {
namespace {

double distance_to_walls(const FlatWorld& world, const Eigen::Vector2d& p) {
  double nearest = 1e9;
  for (const auto& [a, b] : world.walls) {
    const Eigen::Vector2d e = b - a;
    const double t = std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (a + t * e - p).norm());
  }
  return nearest;
}

TEST(ReadScan, PointsOfAMountedLidarLieOnTheWalls) {
  const FlatWorld world;
  std::mt19937 rng(1);
  for (const double roll : {0.0, M_PI}) {  // upright and upside down
    RobotModel robot = test_robot();
    robot.T_base_lidar = from_xyz_rpy(0.1, 0.05, 0.3, roll, 0.0, 0.4);
    const LaserScan scan = sweep(world, robot, test_path, 3.0, 0, 0.0, rng);
    const ScanPoints points = read_scan(scan, robot, {}, 30.0);
    EXPECT_EQ(points.hits_base.size(), 360U);
    for (const auto& p : points.hits_base)
      EXPECT_LT(distance_to_walls(world, test_path(3.0) * p), 1e-4);
    EXPECT_NEAR(points.origin_base.x(), 0.1, 1e-12);
  }
}

TEST(ReadScan, MotionDuringTheSweepIsTakenOut) {
  const FlatWorld world;
  std::mt19937 rng(2);
  RobotModel robot = test_robot();
  robot.lidar.beam_period_s = 0.15 / 360.0;  // a slow, cheap one
  const Twist twist{0.5, 0.0, 0.8};
  const auto path = [&](double t) { return twist.motion(t); };
  const LaserScan scan = sweep(world, robot, path, 0.0, 0, 0.0, rng);
  double worst_with = 0.0, worst_without = 0.0;
  for (const auto& p : read_scan(scan, robot, twist, 30.0).hits_base)
    worst_with = std::max(worst_with, distance_to_walls(world, p));
  for (const auto& p : read_scan(scan, robot, {}, 30.0).hits_base)
    worst_without = std::max(worst_without, distance_to_walls(world, p));
  EXPECT_LT(worst_with, 1e-4);
  EXPECT_GT(worst_without, 0.05);
}

TEST(ReadScan, WhatIsNoReturnIsCounted) {
  RobotModel robot = test_robot();
  LaserScan scan;
  scan.radstep = 0.1;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  scan.ranges_m = {1.0F, nan, inf, -inf, 0.0F, -1.0F, 12.0F, 81.91F, 0.05F, 2.0F, 11.0F};
  const ScanPoints points = read_scan(scan, robot, {}, 10.0);
  EXPECT_EQ(points.hits_base.size(), 2U);
  EXPECT_EQ(points.n_invalid, 9);
}

TEST(Twist, MotionAndItsInverse) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> u(-2.0, 2.0);
  for (int i = 0; i < 100; ++i) {
    const Twist twist{u(rng), u(rng), i % 5 == 0 ? 1e-9 : u(rng)};
    const Twist back = Twist::from_motion(twist.motion(0.7), 0.7);
    EXPECT_NEAR(back.vx_mps, twist.vx_mps, 1e-9);
    EXPECT_NEAR(back.vy_mps, twist.vy_mps, 1e-9);
    EXPECT_NEAR(back.turn_radps, twist.turn_radps, 1e-9);
    const SE2 twice = twist.motion(0.3) * twist.motion(0.4), once = twist.motion(0.7);
    EXPECT_NEAR(twice.x, once.x, 1e-9);
    EXPECT_NEAR(twice.y, once.y, 1e-9);
  }
}

TEST(VoxelFilter, KeepsOnePointASquareAndEnoughOfThem) {
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> u(-5.0, 5.0);
  Points points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(u(rng), 0.01 * u(rng));
  // Against a set of squares.
  std::set<std::pair<int, int>> seen;
  std::vector<std::size_t> expected;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (seen.emplace(static_cast<int>(std::floor(points[i].x() / 0.5)),
                     static_cast<int>(std::floor(points[i].y() / 0.5)))
            .second)
      expected.push_back(i);
  EXPECT_EQ(voxel_indices(points, 0.5), expected);
  const Points thinned = pick(points, adaptive_voxel_indices(points, 0.5, 100));
  EXPECT_GE(thinned.size(), 100U);
  EXPECT_LE(thinned.size(), 200U);
  EXPECT_EQ(adaptive_voxel_indices(thinned, 0.5, 1000).size(), thinned.size());
}

}  // namespace
}  // namespace fusion_slam
