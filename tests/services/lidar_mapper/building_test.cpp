// Drives through drawn buildings where everything is exact: do the covariances mean what they say,
// does any scanner do, do people and lost scans matter?
#include "tests/services/lidar_mapper/building.hpp"

#include <map>
#include <optional>
#include <string>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "services/lidar_mapper/lidar_mapper.hpp"

namespace fusion_slam {
namespace {

struct Course {
  const FlatWorld& world;
  const Way& way;
  Scanner scanner;
  double from_s = 0.0, to_s = 0.0;
  double rate_hz = 0.0;  // of scans that arrive; 0: the scanner's
  bool odometry = false;
  unsigned seed = 1;
  SE3 T_base_lidar = from_xyz_rpy(0.1, 0.0, 0.2, 0.0, 0.0, 0.0);
};

struct Result {
  MapperCounts counts;
  double worst_m = 0.0;  // of the pose in odom
  double worst_rad = 0.0;
  double nees = 0.0;                                 // of T_previous_base, mean; 3 is right
  Eigen::Vector3d sigmas = Eigen::Vector3d::Zero();  // rms of error / sigma, by axis
  int n = 0;
  std::vector<LidarNode> nodes;
  std::vector<Tile> tiles;
};

template <class Meddle>
Result drive(const Course& course, const Meddle& meddle) {
  RobotModel robot;
  robot.has_lidar = true;
  robot.lidar = course.scanner.model;
  robot.T_base_lidar = course.T_base_lidar;
  LidarMapper mapper(robot);
  std::mt19937 rng(course.seed);
  std::normal_distribution<double> normal;
  const double rate_hz = course.rate_hz > 0.0 ? course.rate_hz : robot.lidar.rate_hz;
  Result r;
  std::map<std::int64_t, SE2> truth_of;
  const SE2 start = course.way(course.from_s);
  SE2 odom, before = start;
  for (double t = course.from_s; t < course.to_s; t += 1.0 / rate_hz) {
    LaserScan scan =
        scanner_sweep(course.world, course.scanner, robot.T_base_lidar, course.way, t, rng);
    const SE2 truth = course.way(t);
    if (course.odometry) {  // 2 % too long, and slipping
      const SE2 step = before.inverse() * truth;
      odom = odom * SE2{step.x * (1.02 + 0.05 * normal(rng)), step.y,
                        step.yaw * (1.0 + 0.05 * normal(rng)) + 0.001 * normal(rng)};
      mapper.add_odometry(scan.utime_us, odom);
      before = truth;
    }
    if (!meddle(t, scan)) continue;
    const MapperOutput out = mapper.add_scan(scan);
    if (!out.pose) continue;
    const SE2 error = (start.inverse() * truth).inverse() * out.pose->T_odom_base;
    r.worst_m = std::max(r.worst_m, std::hypot(error.x, error.y));
    r.worst_rad = std::max(r.worst_rad, std::abs(error.yaw));
    r.tiles.insert(r.tiles.end(), out.tiles.begin(), out.tiles.end());
    if (!out.node) continue;
    truth_of[out.node->id] = truth;
    r.nodes.push_back(*out.node);
    if (out.node->previous_id == 0) continue;
    const SE2 expected = truth_of.at(out.node->previous_id).inverse() * truth;
    const SE2 e = expected.inverse() * out.node->T_previous_base;
    const Eigen::Vector3d xi(e.x, e.y, e.yaw);
    EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(out.node->covariance).info(), Eigen::Success);
    r.nees += xi.dot(out.node->covariance.inverse() * xi);
    r.sigmas += (xi.array().square() / out.node->covariance.diagonal().array()).matrix();
    ++r.n;
  }
  for (Tile& tile : mapper.finish()) r.tiles.push_back(std::move(tile));
  r.nees /= std::max(1, r.n);
  r.sigmas = (r.sigmas / std::max(1, r.n)).cwiseSqrt();
  r.counts = mapper.counts();
  return r;
}

const auto kAsItIs = [](double, LaserScan&) { return true; };

Scanner scanner_named(const std::string& name) {
  for (const Scanner& s : scanners())
    if (s.name == name) return s;
  ADD_FAILURE() << name;
  return scanners()[0];
}

// Normalised squared error 3 is right, less is modest. Between a third and double is honest.
void expect_honest(const Result& r) {
  EXPECT_GT(r.n, 60);
  EXPECT_GT(r.nees, 0.6);
  EXPECT_LT(r.nees, 6.0);
  EXPECT_LT(r.sigmas.maxCoeff(), 2.0);
  EXPECT_GT(r.sigmas.minCoeff(), 0.25);
}

TEST(Building, CovariancesAreHonestInAnOffice) {
  const FlatWorld office = office_building(4, 40.0);
  const Way way = round_of(40.0);
  for (const bool odometry : {false, true}) {
    const Result r =
        drive({office, way, scanner_named("rplidar"), 30.0, 85.0, 0.0, odometry, 3}, kAsItIs);
    expect_honest(r);
    EXPECT_EQ(r.counts.lost, 0);
    EXPECT_LT(r.worst_m, 0.15);
  }
}

// Two bare walls: nothing but the wheels knows how far the robot went, and the covariance says so.
TEST(Building, InABareCorridorTheEllipsesLieAlongItAndAreHonest) {
  const FlatWorld corridor = office_building(1, 80.0, true);
  const Way way({{20.0, 1.1}, {60.0, 1.1}, {20.0, 1.2}});
  Scanner scanner = scanner_named("rplidar");
  scanner.model.range_max_m = 5.0;
  const Result r = drive({corridor, way, scanner, 2.0, 62.0, 0.0, true, 3}, kAsItIs);
  EXPECT_LT(r.nees, 6.0);
  EXPECT_LT(r.sigmas.maxCoeff(), 2.0);
  EXPECT_EQ(r.counts.lost, 0);
  EXPECT_GT(r.counts.weak, r.counts.scans / 2);
  for (const LidarNode& node : r.nodes) {
    if (node.id < 3) continue;
    EXPECT_GT(node.covariance(0, 0), 9.0 * node.covariance(1, 1)) << node.id;
  }
  // 2 % of 30 m is the wheels' own error: the walls must not pull the robot back.
  const SE2 truth = way(2.0).inverse() * way(62.0);
  EXPECT_NEAR(r.nodes.back().T_odom_base.x, 1.02 * truth.x, 0.03 * truth.x);
}

TEST(Building, AnyScannerWillDo) {
  const FlatWorld office = office_building(2, 40.0);
  const Way way = round_of(40.0);
  for (const Scanner& scanner : scanners()) {
    const double rate_hz = std::min(scanner.model.rate_hz, 6.0);
    const double allowed_m = scanner.model.range_max_m < 5.0 ? 0.5 : 0.1;
    const Result r = drive({office, way, scanner, 0.0, 16.0, rate_hz, false, 5}, kAsItIs);
    EXPECT_EQ(r.counts.lost, 0) << scanner.name;
    EXPECT_LT(r.worst_m, allowed_m) << scanner.name;
    EXPECT_LT(r.worst_rad, 0.02) << scanner.name;
  }
}

TEST(Building, LostScansAndAScannerTurnedUpsideDown) {
  const FlatWorld office = office_building(3, 40.0);
  const Way way = round_of(40.0);
  std::mt19937 rng(8);
  const Result r = drive({office, way, scanner_named("sick"), 0.0, 30.0, 0.0, false, 6,
                          from_xyz_rpy(0.1, -0.05, 0.2, M_PI, 0.0, 0.3)},
                         [&](double, LaserScan&) { return rng() % 3 != 0; });
  EXPECT_EQ(r.counts.lost, 0);
  EXPECT_LT(r.worst_m, 0.1);
}

// Somebody walks beside the robot, stands for a while, and walks on: neither the pose nor the map
// keep him.
TEST(Building, PeopleFade) {
  const FlatWorld room;
  RobotModel robot = test_robot();
  LidarMapper mapper(robot);
  std::mt19937 rng(1);
  std::vector<Tile> tiles;
  const auto person_at = [](double t) {
    return Eigen::Vector2d(t < 12.0 ? -3.0 : -3.0 + 0.25 * (t - 12.0), -2.3);
  };
  double worst_m = 0.0;
  SE2 first_truth = test_path(0.0);
  for (double t = 0.0; t < 45.0; t += 0.1) {
    FlatWorld now = room;
    if (t < 25.0) {
      const Eigen::Vector2d c = person_at(t);
      const Eigen::Vector2d corner[4] = {{-0.2, -0.15}, {0.2, -0.15}, {0.2, 0.15}, {-0.2, 0.15}};
      for (int i = 0; i < 4; ++i) now.walls.push_back({c + corner[i], c + corner[(i + 1) % 4]});
    }
    const auto utime_us = static_cast<std::int64_t>(t * 1e6) + 1'000'000;
    const auto out = mapper.add_scan(sweep(now, robot, test_path, t, utime_us, 0.01, rng));
    const SE2 error = (first_truth.inverse() * test_path(t)).inverse() * out.pose->T_odom_base;
    worst_m = std::max(worst_m, std::hypot(error.x, error.y));
    tiles.insert(tiles.end(), out.tiles.begin(), out.tiles.end());
  }
  for (Tile& tile : mapper.finish()) tiles.push_back(std::move(tile));
  EXPECT_LT(worst_m, 0.05);
  TiledGrid map(robot.map_resolution_m);
  for (const Tile& tile : tiles)
    if (tile.key.submap_id == 1) map.tiles()[{tile.key.x, tile.key.y}] = *decode_grid_tile(tile);
  const auto occupied = [&](const Eigen::Vector2d& p_world) {
    const Eigen::Vector2d p = first_truth.inverse() * p_world;
    return map.at(map.cell_of(p.x()), map.cell_of(p.y())) > cell_from_probability(0.5);
  };
  int left = 0, wall = 0;
  for (double x = -3.2; x < 0.2; x += 0.05)
    for (double y = -2.5; y < -2.1; y += 0.05) left += occupied({x, y}) ? 1 : 0;
  for (double x = -2.0; x < 2.0; x += 0.05)
    for (const double y : {-3.05, -3.0, -2.95})
      if (occupied({x, y})) {
        ++wall;
        break;
      }
  EXPECT_LT(left, 20) << "of 560 cells";
  EXPECT_GT(wall, 50) << "of 80";
}

}  // namespace
}  // namespace fusion_slam
