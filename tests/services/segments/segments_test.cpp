// A track that was lost and starts anew with neither wheels nor the other sensor is a segment of
// its own: put where the robot was last, which is wrong. A closure of either sensor joins it to the
// first.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "libs/grid/tiled_grid.hpp"
#include "tests/services/loop_detector/made_up_places.hpp"
#include "tests/services/segments/both_cores.hpp"

namespace fusion_slam {
namespace {

// Round a circle, one step a node.
SE3 on_circle(double radius_m, double angle_rad) {
  return from_xyz_rpy(radius_m * std::sin(angle_rad), radius_m * (1.0 - std::cos(angle_rad)), 0, 0,
                      0, angle_rad);
}

struct Error {
  double m = 0.0;
  double rad = 0.0;
};

Error error_of(const PoseGraph& graph, const NodeId& id, const SE3& T_map_true) {
  const Vector6d error = local(T_map_true, graph.nodes().at(id).T_map_base);
  return {error.head<3>().norm(), error.tail<3>().norm()};
}

// The motion from node to node as a tracker measures it: 2 mm and 1 mrad of noise.
class NoisySteps {
 public:
  explicit NoisySteps(unsigned seed) : random_(seed) {}
  template <class Node>
  void measure(const SE3& T_true_previous, const SE3& T_true, Node* node) {
    Vector6d noise = Vector6d::Zero();
    noise << 0.002 * normal_(random_), 0.002 * normal_(random_), 0, 0, 0, 0.001 * normal_(random_);
    node->T_previous_base = retract(SE3(T_true_previous.inverse() * T_true), noise);
    Vector6d variance;
    variance << Eigen::Vector3d::Constant(4e-6), Eigen::Vector3d::Constant(1e-6);
    node->covariance = variance.asDiagonal();
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

// Camera alone. It passes 22 of the circle's 24 places, the lens is covered for the last two and
// the first (1.6 m, 45 degrees), then it goes round again from the second on.
TEST(Segments, TheCameraJoinsThem) {
  constexpr int kPlaces = 24, kBefore = 22, kAfter = 34;
  RobotModel robot;
  robot.has_camera = true;
  robot.has_lidar = false;
  robot.planar = true;
  robot.T_base_camera = from_xyz_rpy(0.1, 0.0, 0.35, -M_PI / 2, 0.0, -M_PI / 2);
  const CameraModel camera;
  BothCores cores(robot);
  cores.detector.set_camera(camera);
  NoisySteps steps(5);
  const auto truth = [&](int k) { return on_circle(2.0, 2.0 * M_PI * k / kPlaces); };

  std::int64_t id = 0;
  SE3 T_odom = SE3::Identity();
  Error at_restart;
  for (int k = 0; k < kAfter; ++k) {
    if (k >= kBefore && k <= kPlaces) {  // covered
      cores.lost(NodeKind::kKeyframe, (k + 1) * 1'000'000);
      continue;
    }
    const unsigned place = static_cast<unsigned>(k % kPlaces);
    LoopKeyframe keyframe = keyframe_at(
        ++id, see_place(make_place(place + 1), camera, SE3::Identity(), static_cast<unsigned>(k)));
    keyframe.utime_us = (k + 1) * 1'000'000;
    if (k > 0 && k != kPlaces + 1) {
      keyframe.previous_id = id - 1;
      steps.measure(truth(k - 1), truth(k), &keyframe);
      T_odom = T_odom * keyframe.T_previous_base;
    }
    keyframe.T_odom_base = T_odom;  // of the way that was driven blind the tracker knows nothing
    cores.add(keyframe);
    if (k == kPlaces + 1) at_restart = error_of(cores.graph, {NodeKind::kKeyframe, id}, truth(k));
  }
  EXPECT_EQ(cores.graph.counts().restarts, 1);
  EXPECT_GT(at_restart.m, 1.0);  // two segments that don't fit
  EXPECT_GT(at_restart.rad, 0.5);
  cores.finish();

  ASSERT_GE(cores.accepted.size(), 5U);
  for (const LoopCandidate& loop : cores.accepted) {
    EXPECT_EQ(loop.source, LoopSource::kVision);
    EXPECT_LE(loop.from.id, kBefore);
    EXPECT_GT(loop.to.id, kBefore);
  }
  EXPECT_TRUE(cores.graph.switched_off().empty());
  for (std::int64_t node = kBefore + 1; node <= id; ++node) {
    const Error error = error_of(cores.graph, {NodeKind::kKeyframe, node},
                                 truth(static_cast<int>(node) - kBefore + kPlaces));
    EXPECT_LT(error.m, 0.05) << "keyframe " << node;
    EXPECT_LT(error.rad, 0.02) << "keyframe " << node;
  }
}

constexpr double kCell_m = 0.05;
constexpr std::uint8_t kFree = 20, kWall = 230;

// Walls around x in [-3, 3], y in [-2, 2] and three pillars, so that it looks alike from nowhere
// else.
TiledGrid room() {
  TiledGrid grid(kCell_m);
  const auto fill = [&](int x0, int x1, int y0, int y1, std::uint8_t value) {
    for (int x = x0; x <= x1; ++x)
      for (int y = y0; y <= y1; ++y) grid.set(x, y, value);
  };
  fill(-62, 62, -42, 42, kFree);
  fill(-62, 62, 40, 41, kWall);
  fill(-62, 62, -41, -40, kWall);
  fill(60, 61, -42, 42, kWall);
  fill(-61, -60, -42, 42, kWall);
  fill(30, 38, 18, 26, kWall);
  fill(-45, -40, -20, -5, kWall);
  fill(20, 23, -30, -27, kWall);
  return grid;
}

// End points on the walls, told in the frame of a robot at T.
Points scan_from(const TiledGrid& grid, const SE2& T) {
  Points points;
  for (int i = 0; i < 180; ++i) {
    const double a = i * M_PI / 90.0;
    for (int cm = 30; cm < 700; ++cm) {
      const double r = 0.01 * cm;
      const Eigen::Vector2d p = T * Eigen::Vector2d(r * std::cos(a), r * std::sin(a));
      if (grid.at(grid.cell_of(p.x()), grid.cell_of(p.y())) != kWall) continue;
      points.emplace_back((r + 0.02) * std::cos(a), (r + 0.02) * std::sin(a));
      break;
    }
  }
  return points;
}

// Both sensors are blind for a while (0.55 m, 46 degrees) and start anew; the camera knows nothing
// again. The LiDAR's closures join its own segments, and the camera's come along by their ties.
TEST(Segments, TheLidarJoinsThemAndTheCameraComesAlong) {
  constexpr int kBefore = 75, kBlind = 8, kAfter = 60, kInSubmap = 20, kPerKeyframe = 10;
  RobotModel robot;
  robot.has_camera = robot.has_lidar = robot.planar = true;
  BothCores cores(robot);
  NoisySteps lidar_steps(6), camera_steps(7);
  const TiledGrid grid = room();
  const auto truth = [](int k) { return on_circle(0.7, 0.1 * k); };

  std::int64_t scan_id = 0, keyframe_id = 0;
  int keyframe_at_step = 0;
  SE3 T_odom_scan = SE3::Identity(), T_odom_keyframe = SE3::Identity();
  std::map<NodeId, int> step_of;
  Error at_restart;
  for (int k = 0; k < kBefore + kBlind + kAfter; ++k) {
    const std::int64_t utime_us = (k + 1) * 150'000;
    if (k >= kBefore && k < kBefore + kBlind) {
      cores.lost(NodeKind::kKeyframe, utime_us);
      cores.lost(NodeKind::kLidar, utime_us);
      continue;
    }
    const bool anew = k == 0 || k == kBefore + kBlind;
    LoopScan scan;
    scan.id = ++scan_id;
    scan.utime_us = utime_us;
    if (!anew) {
      scan.previous_id = scan.id - 1;
      lidar_steps.measure(truth(k - 1), truth(k), &scan);
      T_odom_scan = T_odom_scan * scan.T_previous_base;
    }
    scan.T_odom_base = T_odom_scan;
    scan.points_base = scan_from(grid, to_se2(truth(k)));
    // The first submap is told by its tiles; the others' have not come.
    scan.submaps = {{k < kInSubmap ? 1 : (k < kBefore ? 21 : 76), truth(k)}};
    step_of[{NodeKind::kLidar, scan.id}] = k;
    if (anew || (k - keyframe_at_step) % kPerKeyframe == 0) {
      LoopKeyframe keyframe;
      keyframe.id = ++keyframe_id;
      keyframe.utime_us = utime_us;
      if (!anew) {
        keyframe.previous_id = keyframe.id - 1;
        camera_steps.measure(truth(keyframe_at_step), truth(k), &keyframe);
        T_odom_keyframe = T_odom_keyframe * keyframe.T_previous_base;
      }
      keyframe.T_odom_base = T_odom_keyframe;
      keyframe_at_step = k;
      step_of[{NodeKind::kKeyframe, keyframe.id}] = k;
      cores.add(scan);
      cores.add(keyframe);
    } else {
      cores.add(scan);
    }
    if (k == kInSubmap)
      for (const auto& [at, cells] : grid.tiles())
        cores.detector.add_tile(
            encode_grid_tile({1, at.first, at.second, 0}, cells, kCell_m, 1, utime_us));
    if (anew) at_restart = error_of(cores.graph, {NodeKind::kLidar, scan.id}, truth(k));
  }
  EXPECT_EQ(cores.graph.counts().restarts, 1);  // the LiDAR's; the keyframe hangs in its trajectory
  EXPECT_GT(at_restart.m, 0.4);
  EXPECT_GT(at_restart.rad, 0.5);
  cores.finish();

  int joining = 0;
  for (const LoopCandidate& loop : cores.accepted) {
    EXPECT_EQ(loop.source, LoopSource::kLidar);
    joining += loop.to.id > kBefore ? 1 : 0;
  }
  EXPECT_GE(joining, 5);  // where nothing is known of the way between, one is not enough
  for (const auto& [id, k] : step_of) {
    if (k < kBefore) continue;
    const Error error = error_of(cores.graph, id, truth(k));
    EXPECT_LT(error.m, 0.05) << k;
    EXPECT_LT(error.rad, 0.02) << k;
  }
}

// Two rooms of one plan, 12 m apart; both mapped, then silence, then one of them: nobody can tell
// which. No closure is better than the wrong one.
TEST(Segments, ARoomThatThereAreTwoOfIsNotJoined) {
  constexpr int kInRoom = 20, kBlind = 30, kAfter = 45;
  RobotModel robot;
  robot.has_camera = false;
  robot.has_lidar = robot.planar = true;
  BothCores cores(robot);
  NoisySteps steps(8);
  const TiledGrid grid = room();
  const auto in_room = [](int k) { return on_circle(0.7, 0.1 * k); };
  const SE3 T_first_second = from_xyz_rpy(12, 0, 0, 0, 0, 0);
  const auto truth = [&](int k) {
    return k < kInRoom ? in_room(k) : SE3(T_first_second * in_room(k - kInRoom));
  };

  std::int64_t id = 0;
  SE3 T_odom = SE3::Identity();
  for (int k = 0; k < 2 * kInRoom + kBlind + kAfter; ++k) {
    const std::int64_t utime_us = (k + 1) * 150'000;
    const bool second_segment = k >= 2 * kInRoom + kBlind;
    if (k >= 2 * kInRoom && !second_segment) {
      cores.lost(NodeKind::kLidar, utime_us);
      continue;
    }
    LoopScan scan;
    scan.id = ++id;
    scan.utime_us = utime_us;
    if (k != 0 && k != 2 * kInRoom + kBlind) {
      scan.previous_id = id - 1;
      steps.measure(truth(k - 1), truth(k), &scan);
      T_odom = T_odom * scan.T_previous_base;
    }
    scan.T_odom_base = T_odom;
    scan.points_base = scan_from(grid, to_se2(in_room(k - (k < kInRoom ? 0 : kInRoom))));
    if (k < kInRoom)
      scan.submaps = {{1, in_room(k)}};
    else
      scan.submaps = {{second_segment ? 2 * kInRoom + 1 : kInRoom + 1, in_room(k - kInRoom)}};
    cores.add(scan);
    if (k == 2 * kInRoom - 1)
      for (const auto& [at, cells] : grid.tiles())
        for (const std::int64_t submap : {1, kInRoom + 1})
          cores.detector.add_tile(
              encode_grid_tile({submap, at.first, at.second, 0}, cells, kCell_m, 1, utime_us));
  }
  cores.finish();
  EXPECT_TRUE(cores.accepted.empty());
  int told = 0;
  for (const LoopCandidate& c : cores.rejected)
    told += c.stages[2].reason.find("fits as well 12.0 m") != std::string::npos ? 1 : 0;
  EXPECT_GE(told, 2);
}

}  // namespace
}  // namespace fusion_slam
