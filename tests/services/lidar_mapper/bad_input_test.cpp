// What sensors and logs really send: repeated, late and rounded stamps, holes, nonsense.
#include <limits>

#include <gtest/gtest.h>

#include "services/lidar_mapper/lidar_mapper.hpp"
#include "tests/services/lidar_mapper/flat_world.hpp"

namespace fusion_slam {
namespace {

TEST(BadInput, StampsThatLieDoNotBendTheTrajectory) {
  const RobotModel robot = test_robot();
  const FlatWorld world;
  LidarMapper mapper(robot);
  std::mt19937 rng(1);
  std::uniform_int_distribution<int> kind(0, 5);
  const SE2 start = test_path(0.0);
  std::int64_t last_us = 0;
  for (int i = 0; i < 150; ++i) {
    const double t = 0.1 * i;
    std::int64_t utime_us = static_cast<std::int64_t>(t * 1e6) + 1'000'000;
    switch (kind(rng)) {
      case 0:
        utime_us = last_us;  // repeated
        break;
      case 1:
        utime_us -= 150'000;  // backwards
        break;
      case 2:
        utime_us = utime_us / 50'000 * 50'000;  // rounded
        break;
      default:
        break;
    }
    last_us = utime_us;
    const auto out = mapper.add_scan(sweep(world, robot, test_path, t, utime_us, 0.01, rng));
    ASSERT_TRUE(out.pose);
    const SE2 truth = start.inverse() * test_path(t);
    ASSERT_LT(std::hypot(out.pose->T_odom_base.x - truth.x, out.pose->T_odom_base.y - truth.y),
              0.06)
        << i;
  }
  EXPECT_GT(mapper.counts().doubtful_stamps, 20);
}

TEST(BadInput, ARepeatedScanIsDropped) {
  const RobotModel robot = test_robot();
  LidarMapper mapper(robot);
  std::mt19937 rng(1);
  LaserScan scan = sweep(FlatWorld{}, robot, test_path, 0.0, 5, 0.01, rng);
  scan.ranges_m[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(mapper.add_scan(scan).pose);
  EXPECT_FALSE(mapper.add_scan(scan).pose);
  EXPECT_EQ(mapper.counts().duplicates, 1);
}

TEST(BadInput, EmptyAndSenselessScansLeaveThePoseWhereItIs) {
  const RobotModel robot = test_robot();
  LidarMapper mapper(robot);
  LaserScan empty;
  EXPECT_FALSE(mapper.add_scan(empty).pose);
  std::mt19937 rng(1);
  ASSERT_TRUE(mapper.add_scan(sweep(FlatWorld{}, robot, test_path, 0.0, 100'000, 0.01, rng)).node);
  for (int i = 0; i < 40; ++i) {
    LaserScan bad;
    bad.utime_us = 200'000 + 100'000 * i;
    bad.rad0 = -3.0;
    bad.radstep = 0.1;
    bad.ranges_m.assign(60, i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.0F);
    const auto out = mapper.add_scan(bad);
    ASSERT_TRUE(out.pose);
    EXPECT_EQ(out.pose->state, MatchState::kLost);
    EXPECT_FALSE(out.node);
    EXPECT_NEAR(out.pose->T_odom_base.x, 0.0, 1e-9);
  }
  const auto back = mapper.add_scan(sweep(
      FlatWorld{}, robot, [](double) { return test_path(0.0); }, 0.0, 4'300'000, 0.01, rng));
  EXPECT_EQ(back.pose->state, MatchState::kOk);
}

// Carried to another building: the map goes on there, hung on the last node with a variance that
// says how little is known.
TEST(BadInput, AfterBeingLostForLongANewMapBegins) {
  const RobotModel robot = test_robot();
  FlatWorld here, there;
  there.walls = {{{-1, -1}, {1, -0.6}},
                 {{1, -0.6}, {0.8, 2}},
                 {{0.8, 2}, {-1.2, 1.4}},
                 {{-1.2, 1.4}, {-1, -1}}};
  LidarMapper mapper(robot);
  std::mt19937 rng(1);
  const auto still = [](double) { return SE2{}; };
  std::vector<LidarNode> nodes;
  for (int i = 0; i < 60; ++i) {
    const auto out = mapper.add_scan(
        sweep(i < 20 ? here : there, robot, still, 0.0, 100'000 * (i + 1), 0.005, rng));
    if (out.node) nodes.push_back(*out.node);
    EXPECT_TRUE(i != 59 || out.pose->state == MatchState::kOk);
  }
  EXPECT_EQ(mapper.counts().restarts, 1);
  ASSERT_EQ(nodes.size(), 2U);
  EXPECT_EQ(nodes[1].submaps.size(), 1U);
  EXPECT_EQ(nodes[1].submaps[0].submap_id, 2);
  EXPECT_GT(nodes[1].covariance(0, 0), 0.1);
}

}  // namespace
}  // namespace fusion_slam
