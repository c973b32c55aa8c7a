#include "services/lidar_mapper/lidar_mapper.hpp"

#include <map>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/services/lidar_mapper/flat_world.hpp"

namespace fusion_slam {
namespace {

struct Drive {
  std::vector<LidarPose> poses;
  std::vector<LidarNode> nodes;
  std::vector<Tile> tiles;
};

template <class Path, class Before>
Drive drive(LidarMapper& mapper, const RobotModel& robot, const Path& path, int n, double period_s,
            const Before& before) {
  const FlatWorld world;
  std::mt19937 rng(1);
  Drive result;
  for (int i = 0; i < n; ++i) {
    const double t = i * period_s;
    const auto utime_us = static_cast<std::int64_t>(t * 1e6) + 1'000'000;
    before(t, utime_us);
    const MapperOutput out = mapper.add_scan(sweep(world, robot, path, t, utime_us, 0.01, rng));
    if (out.pose) result.poses.push_back(*out.pose);
    if (out.node) result.nodes.push_back(*out.node);
    result.tiles.insert(result.tiles.end(), out.tiles.begin(), out.tiles.end());
  }
  for (Tile& tile : mapper.finish()) result.tiles.push_back(std::move(tile));
  return result;
}

const auto kNothing = [](double, std::int64_t) {};

template <class Path>
double worst_error_m(const Drive& result, const Path& path, double period_s) {
  double worst = 0.0;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    const SE2 truth = path(0.0).inverse() * path(static_cast<double>(i) * period_s);
    const SE2& T = result.poses[i].T_odom_base;
    worst = std::max(worst, std::hypot(T.x - truth.x, T.y - truth.y));
  }
  return worst;
}

// Killed after half of the drive and started again from its nodes, half a second of scans later.
TEST(LidarMapper, GoesOnFromItsNodesAfterAGap) {
  const RobotModel robot = test_robot();
  LidarMapper first(robot);
  const Drive before = drive(first, robot, test_path, 100, 0.1, kNothing);
  LidarMapper second(robot);
  const std::vector<Tile> tiles = second.resume(before.nodes);
  EXPECT_FALSE(tiles.empty());
  const FlatWorld world;
  std::mt19937 rng(2);
  for (int i = 105; i < 140; ++i) {
    const double t = i * 0.1;
    const auto utime_us = static_cast<std::int64_t>(t * 1e6) + 1'000'000;
    const MapperOutput out =
        second.add_scan(sweep(world, robot, test_path, t, utime_us, 0.01, rng));
    ASSERT_TRUE(out.pose);
    const SE2 truth = test_path(0.0).inverse() * test_path(t);
    const SE2& T = out.pose->T_odom_base;
    EXPECT_LT(std::hypot(T.x - truth.x, T.y - truth.y), 0.05) << "scan " << i;
    if (!out.node) continue;
    EXPECT_GT(out.node->id, before.nodes.back().id);
    EXPECT_NE(out.node->previous_id, 0) << "the chain goes on";
    EXPECT_EQ(out.node->submaps.front().submap_id, before.nodes.back().submaps.front().submap_id);
  }
  EXPECT_EQ(second.counts().lost, 0);
  EXPECT_EQ(second.counts().restarts, 0);
}

// A power cut: the journal has lost the last node, which others know.
TEST(LidarMapper, GivesNoIdTwiceWhenTheLastNodeIsForgotten) {
  const RobotModel robot = test_robot();
  LidarMapper first(robot);
  Drive before = drive(first, robot, test_path, 60, 0.1, kNothing);
  ASSERT_GE(before.nodes.size(), 3U);
  before.nodes.pop_back();
  const LidarNode& last = before.nodes.back();
  LidarMapper second(robot);
  second.resume(before.nodes, 1001);
  const FlatWorld world;
  std::mt19937 rng(2);
  std::vector<LidarNode> nodes;
  for (int i = 62; i < 90 && nodes.size() < 2; ++i) {
    const double t = i * 0.1;
    const auto utime_us = static_cast<std::int64_t>(t * 1e6) + 1'000'000;
    const MapperOutput out =
        second.add_scan(sweep(world, robot, test_path, t, utime_us, 0.01, rng));
    if (!out.node) continue;
    const SE2 truth = test_path(0.0).inverse() * test_path(t);
    const SE2 hung = (nodes.empty() ? last : nodes.back()).T_odom_base * out.node->T_previous_base;
    EXPECT_LT(std::hypot(hung.x - truth.x, hung.y - truth.y), 0.05);
    nodes.push_back(*out.node);
  }
  ASSERT_EQ(nodes.size(), 2U);
  EXPECT_EQ(nodes[0].id, 1001);
  EXPECT_EQ(nodes[0].previous_id, last.id);
  EXPECT_EQ(nodes[1].id, 1002);
  EXPECT_EQ(nodes[1].previous_id, 1001);
  LidarMapper third(robot);  // nothing is left
  EXPECT_TRUE(third.resume({}, 1001).empty());
  const MapperOutput out =
      third.add_scan(sweep(world, robot, test_path, 0.0, 1'000'000, 0.01, rng));
  ASSERT_TRUE(out.node);
  EXPECT_EQ(out.node->id, 1001);
  EXPECT_EQ(out.node->previous_id, 0);
}

// The robot drives for `silent_s` seconds of which the mapper hears no scan, then for 5 s more.
Drive drive_with_silence(LidarMapper& mapper, double silent_s, bool with_wheels) {
  const RobotModel robot = test_robot();
  const FlatWorld world;
  std::mt19937 rng(3);
  Drive result;
  for (int i = 0; i < 100 + static_cast<int>(10 * silent_s); ++i) {
    const double t = 0.1 * i;
    const auto utime_us = static_cast<std::int64_t>(t * 1e6) + 1'000'000;
    if (with_wheels) mapper.add_odometry(utime_us, test_path(t));
    if (t > 5.0 && t < 5.0 + silent_s) continue;
    const MapperOutput out =
        mapper.add_scan(sweep(world, robot, test_path, t, utime_us, 0.01, rng));
    if (out.pose) result.poses.push_back(*out.pose);
    if (out.node) result.nodes.push_back(*out.node);
  }
  return result;
}

// After 12 s of silence the robot may be anywhere: no match with what was near is worth an edge.
TEST(LidarMapper, ALongSilenceBeginsASegment) {
  LidarMapper mapper(test_robot());
  const Drive result = drive_with_silence(mapper, 12.0, false);
  EXPECT_EQ(mapper.counts().segments, 1);
  EXPECT_EQ(mapper.counts().lost, 1);
  int beginnings = 0;
  for (const LidarNode& node : result.nodes) {
    EXPECT_TRUE(node.previous_id == 0 || node.previous_id == node.id - 1);
    if (node.previous_id != 0 || node.id == 1) continue;
    ++beginnings;
    EXPECT_GE(node.utime_us, 18'000'000);
    ASSERT_EQ(node.submaps.size(), 1U);
    EXPECT_EQ(node.submaps[0].submap_id, node.id) << "a map of its own";
  }
  EXPECT_EQ(beginnings, 1);
  for (const LidarPose& pose : result.poses)
    if (pose.state == MatchState::kLost) {
      EXPECT_NEAR(static_cast<double>(pose.utime_us), 18e6, 0.11e6);
      EXPECT_NE(pose.reason.find("silence"), std::string::npos);
    }
  EXPECT_EQ(result.poses.back().state, MatchState::kOk);
}

TEST(LidarMapper, AShortSilenceOrWheelsKeepTheChain) {
  LidarMapper short_silence(test_robot()), wheels(test_robot());
  const Drive one = drive_with_silence(short_silence, 1.0, false);
  const Drive two = drive_with_silence(wheels, 12.0, true);
  EXPECT_EQ(short_silence.counts().segments, 0);
  EXPECT_EQ(wheels.counts().segments, 0);
  for (const Drive* d : {&one, &two})
    for (const LidarNode& node : d->nodes) EXPECT_EQ(node.previous_id, node.id - 1);
  const SE2 truth = test_path(0.0).inverse() * test_path(21.9);
  EXPECT_LT(std::hypot(two.poses.back().T_odom_base.x - truth.x,
                       two.poses.back().T_odom_base.y - truth.y),
            0.05);
}

// Scans after the silence that show nothing change nothing of how long it was.
TEST(LidarMapper, EmptyScansDoNotEndASilence) {
  LidarMapper mapper(test_robot());
  const FlatWorld world;
  std::mt19937 rng(4);
  const auto still = [](double) { return SE2{}; };
  for (int i = 0; i < 10; ++i)
    mapper.add_scan(sweep(world, test_robot(), still, 0.0, 100'000 * (i + 1), 0.01, rng));
  LaserScan empty;
  empty.rad0 = -3.0;
  empty.radstep = 0.1;
  empty.ranges_m.assign(60, 0.0F);
  for (int i = 0; i < 3; ++i) {
    empty.utime_us = 10'000'000 + 100'000 * i;
    EXPECT_FALSE(mapper.add_scan(empty).node);
  }
  const auto out = mapper.add_scan(sweep(world, test_robot(), still, 0.0, 10'300'000, 0.01, rng));
  ASSERT_TRUE(out.node);
  EXPECT_EQ(out.node->previous_id, 0);
}

TEST(LidarMapper, FollowsAPathWithScansAlone) {
  const RobotModel robot = test_robot();
  LidarMapper mapper(robot);
  const Drive result = drive(mapper, robot, test_path, 200, 0.1, kNothing);
  ASSERT_EQ(result.poses.size(), 200U);
  EXPECT_LT(worst_error_m(result, test_path, 0.1), 0.04);
  EXPECT_EQ(mapper.counts().lost, 0);
  EXPECT_GT(result.nodes.size(), 20U);
  EXPECT_LT(result.nodes.size(), 150U);
}

TEST(LidarMapper, UpsideDownAndSweepingSlowly) {
  RobotModel robot = test_robot();
  robot.T_base_lidar = from_xyz_rpy(0.1, 0.0, 0.2, M_PI, 0.0, 0.0);
  robot.lidar.rate_hz = 5.5;
  robot.lidar.beam_period_s = 1.0 / 5.5 / 360.0;
  LidarMapper mapper(robot);
  // From rest: the first sweep defines the frame, and nobody knows how fast the robot is during it.
  const auto path = [](double t) { return test_path(t < 2.0 ? 0.25 * t * t : t - 1.0); };
  const Drive result = drive(mapper, robot, path, 110, 1.0 / 5.5, kNothing);
  EXPECT_LT(worst_error_m(result, path, 1.0 / 5.5), 0.06);
}

TEST(LidarMapper, NodesPosesAndTilesFitTogether) {
  const RobotModel robot = test_robot();
  LidarMapper mapper(robot);
  const Drive result = drive(mapper, robot, test_path, 150, 0.1, kNothing);
  std::map<std::int64_t, SE2> at;  // node poses
  for (const LidarNode& node : result.nodes) {
    EXPECT_EQ(node.id, static_cast<std::int64_t>(at.size()) + 1);
    EXPECT_EQ(node.previous_id, node.id - 1);
    if (node.previous_id != 0) {
      EXPECT_NEAR((at.at(node.previous_id) * node.T_previous_base).x, node.T_odom_base.x, 1e-9);
      EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(node.covariance).info(), Eigen::Success);
      EXPECT_LT(node.covariance(0, 0), 0.05 * 0.05);
    }
    at[node.id] = node.T_odom_base;
    ASSERT_FALSE(node.submaps.empty());
    for (const auto& m : node.submaps)
      EXPECT_NEAR((at.at(m.submap_id) * m.T_submap_base).y, node.T_odom_base.y, 1e-9);
  }
  for (const LidarPose& pose : result.poses)
    EXPECT_NEAR((at.at(pose.reference_id) * pose.T_reference_base).x, pose.T_odom_base.x, 1e-9);
  // The wall ahead of the start (x = 6 in the world) is occupied in the first submap.
  const SE2 start = test_path(0.0);
  TiledGrid first(robot.map_resolution_m);
  for (const Tile& tile : result.tiles)
    if (tile.key.submap_id == 1) first.tiles()[{tile.key.x, tile.key.y}] = *decode_grid_tile(tile);
  int occupied = 0, total = 0;
  for (; total < 50; ++total) {
    const double y = -2.5 + 0.1 * total;
    const Eigen::Vector2d p = start.inverse() * Eigen::Vector2d(-4.0, y * 0.5 + 1.0);
    for (int dx = -1; dx <= 1; ++dx)
      if (first.at(first.cell_of(p.x()) + dx, first.cell_of(p.y())) > 160) {
        ++occupied;
        break;
      }
  }
  EXPECT_GT(occupied, total * 8 / 10);
}

TEST(LidarMapper, StandingStillMakesNoNodes) {
  const RobotModel robot = test_robot();
  LidarMapper mapper(robot);
  const auto still = [](double) { return SE2{0.3, 0.2, 0.1}; };
  const Drive result = drive(mapper, robot, still, 100, 0.1, kNothing);
  EXPECT_EQ(result.nodes.size(), 1U);
  EXPECT_LT(worst_error_m(result, still, 0.1), 0.02);
}

// The world is a corridor without ends: only odometry knows how far the robot went.
TEST(LidarMapper, InACorridorOdometryCarriesAndTheVarianceSaysSo) {
  RobotModel robot = test_robot();
  robot.lidar.range_max_m = 5.0;
  FlatWorld corridor;
  corridor.walls = {{{-90, 1}, {90, 1}}, {{-90, -1.2}, {90, -1.2}}};
  LidarMapper mapper(robot);
  std::mt19937 rng(1);
  const auto path = [](double t) { return SE2{0.4 * t, 0.0, 0.0}; };
  MapperOutput out;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.1 * i;
    const auto utime_us = static_cast<std::int64_t>(1e6 + t * 1e6);
    mapper.add_odometry(utime_us, path(t));
    out = mapper.add_scan(sweep(corridor, robot, path, t, utime_us, 0.01, rng));
  }
  EXPECT_NEAR(out.pose->T_odom_base.x, path(5.9).x, 0.15);
  EXPECT_NEAR(out.pose->T_odom_base.y, 0.0, 0.03);
  EXPECT_GT(out.pose->covariance(0, 0), 20.0 * out.pose->covariance(1, 1));
  EXPECT_EQ(out.pose->state, MatchState::kWeak);
}

TEST(LidarMapper, EqualInputGivesEqualBits) {
  const RobotModel robot = test_robot();
  LidarMapper a(robot), b(robot);
  const Drive first = drive(a, robot, test_path, 80, 0.1, kNothing);
  const Drive second = drive(b, robot, test_path, 80, 0.1, kNothing);
  ASSERT_EQ(first.tiles.size(), second.tiles.size());
  for (std::size_t i = 0; i < first.tiles.size(); ++i)
    ASSERT_EQ(first.tiles[i].data, second.tiles[i].data);
  for (std::size_t i = 0; i < first.poses.size(); ++i)
    ASSERT_EQ(first.poses[i].T_odom_base.x, second.poses[i].T_odom_base.x);
}

TEST(LidarMapper, ResetBeginsANewMapWhereTheRobotIs) {
  const RobotModel robot = test_robot();
  LidarMapper mapper(robot);
  const Drive before = drive(mapper, robot, test_path, 40, 0.1, kNothing);
  const std::int64_t last_id = before.nodes.back().id;
  mapper.reset();
  std::mt19937 rng(2);
  Drive after;
  for (int i = 40; i < 120; ++i) {
    const MapperOutput out = mapper.add_scan(
        sweep(FlatWorld{}, robot, test_path, 0.1 * i, 1'000'000 + 100'000 * i, 0.01, rng));
    after.poses.push_back(*out.pose);
    if (out.node) after.nodes.push_back(*out.node);
    EXPECT_NE(out.pose->state, MatchState::kLost);
  }
  ASSERT_GT(after.nodes.size(), 1U);
  EXPECT_EQ(after.nodes[0].id, last_id + 1);
  EXPECT_EQ(after.nodes[0].previous_id, 0);
  EXPECT_EQ(after.nodes[1].previous_id, last_id + 1);
  for (const LidarNode& node : after.nodes)
    for (const auto& in : node.submaps) EXPECT_GT(in.submap_id, last_id);
  // odom goes on: nobody who listens to it sees a jump.
  std::vector<LidarPose> all = before.poses;
  all.insert(all.end(), after.poses.begin(), after.poses.end());
  EXPECT_LT(worst_error_m({all, {}, {}}, test_path, 0.1), 0.08);
  EXPECT_LT(after.poses.front().covariance.norm(), before.poses.back().covariance.norm() + 1e-3);
}

}  // namespace
}  // namespace fusion_slam
