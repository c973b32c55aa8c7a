#include "services/pose_graph/sensor_agreement.hpp"

#include <gtest/gtest.h>

#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {
namespace {

constexpr double kGate = 30.0;

GraphEdge visual_edge(const SE3& T_from_to, double sigma) {
  GraphEdge edge;
  edge.T_from_to = T_from_to;
  edge.covariance = Matrix6d::Identity() * sigma * sigma;
  return edge;
}

LidarSays lidar_says(const SE3& T_from_to, double along_m) {
  LidarSays lidar{T_from_to, Matrix6d::Identity() * 1e-4};
  lidar.covariance(0, 0) = along_m * along_m;
  return lidar;
}

TEST(SensorAgreement, OnlyAContradictionIsDoubted) {
  const EdgeNoiseConfig noise;
  const SE3 T = from_xyz_rpy(0.2, 0.01, 0, 0, 0, 0.1);
  const auto doubted = [&](const SE3& error, double along_m) {
    return doubted_covariance(noise, visual_edge(T * error, 0.002), lidar_says(T, along_m), true,
                              kGate);
  };
  EXPECT_FALSE(doubted(SE3::Identity(), 0.01));
  EXPECT_FALSE(doubted(from_xyz_rpy(0.03, -0.03, 0, 0, 0, 0.03), 0.01));
  EXPECT_FALSE(
      doubted(from_xyz_rpy(0, 0, 0.5, 0.05, 0.05, 0), 0.01));  // a scan knows nothing of it
  EXPECT_TRUE(doubted(from_xyz_rpy(0.4, 0, 0, 0, 0, 0), 0.01));
  EXPECT_FALSE(doubted(from_xyz_rpy(0.4, 0, 0, 0, 0, 0), 0.3)) << "along a corridor";
  EXPECT_TRUE(doubted(from_xyz_rpy(0, 0.4, 0, 0, 0, 0), 0.3)) << "across it";
}

TEST(SensorAgreement, ADoubtedEdgeAllowsForTheDifference) {
  const SE3 T = from_xyz_rpy(0.2, 0, 0, 0, 0, 0.1);
  const GraphEdge edge = visual_edge(T * from_xyz_rpy(0.3, -0.4, 0, 0, 0, 0.2), 0.002);
  const auto doubted = doubted_covariance({}, edge, lidar_says(T, 0.01), true, kGate);
  ASSERT_TRUE(doubted);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR((*doubted)(i, i), 0.25, 0.01);
  for (int i = 3; i < 6; ++i) EXPECT_NEAR((*doubted)(i, i), 0.04, 1e-3);
  GraphEdge then = edge;
  then.covariance = *doubted;
  EXPECT_FALSE(doubted_covariance({}, then, lidar_says(T, 0.01), true, kGate)) << "once is enough";
}

// Keyframes each 0.2 s, LiDAR nodes at the same times; the camera errs once, by 0.5 m and 0.2 rad,
// and is sure to 2 mm.
struct Drive {
  PoseGraph graph;

  static SE3 truth(std::int64_t k) { return from_xyz_rpy(0.1 * k, 0, 0, 0, 0, 0.03 * k); }

  explicit Drive(bool lidar) {
    RobotModel robot;
    robot.has_camera = robot.planar = true;
    robot.has_lidar = lidar;
    graph.set_robot(robot);
    SE3 T_odom_camera = SE3::Identity();
    for (std::int64_t k = 1; k <= 30; ++k) {
      if (lidar) add(NodeKind::kLidar, k, truth(k - 1).inverse() * truth(k), truth(k), 0.005);
      SE3 T_step = truth(k - 1).inverse() * truth(k);
      if (k == 15) T_step = T_step * from_xyz_rpy(0.5, 0, 0, 0, 0, -0.2);
      T_odom_camera = T_odom_camera * T_step;
      add(NodeKind::kKeyframe, k, T_step, T_odom_camera, 0.002);
    }
    graph.finish();
  }

  void add(NodeKind kind, std::int64_t k, const SE3& T_step, const SE3& T_odom, double sigma) {
    NodeInput node;
    node.id = {kind, k};
    node.utime_us = k * 200'000;
    node.previous_id = k - 1;
    node.T_previous_base = T_step;
    node.T_odom_base = T_odom;
    node.covariance = Matrix6d::Identity() * sigma * sigma;
    graph.add_node(node);
    PoseInput pose;
    pose.sensor = kind;
    pose.utime_us = pose.fix_utime_us = node.utime_us;
    pose.T_odom_base = T_odom;
    pose.covariance = node.covariance;
    pose.state = PoseState::kOk;
    pose.reference = node.id;
    graph.add_pose(pose);
  }

  double error_m(std::int64_t k) const {
    const SE3 T = truth(1).inverse() * truth(k);
    return (graph.nodes().at({NodeKind::kKeyframe, k}).T_map_base.translation() - T.translation())
        .norm();
  }
};

TEST(SensorAgreement, AWrongEdgeOfTheCameraBendsNothingThatTheLidarSaw) {
  Drive both(true);
  EXPECT_EQ(both.graph.counts().edges_doubted, 1);
  for (std::int64_t k = 1; k <= 30; ++k) EXPECT_LT(both.error_m(k), 0.02) << k;
  Drive alone(false);
  EXPECT_EQ(alone.graph.counts().edges_doubted, 0);
  EXPECT_GT(alone.error_m(30), 0.4);
}

}  // namespace
}  // namespace fusion_slam
