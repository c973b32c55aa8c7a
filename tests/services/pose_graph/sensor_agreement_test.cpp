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

constexpr std::int64_t kPeriod_us = 200'000;
SE3 truth(std::int64_t k) { return from_xyz_rpy(0.1 * k, 0, 0, 0, 0, 0.03 * k); }

double error_m(const PoseGraph& graph, std::int64_t k) {
  const SE3 T = truth(1).inverse() * truth(k);
  return (graph.nodes().at({NodeKind::kKeyframe, k}).T_map_base.translation() - T.translation())
      .norm();
}

// Keyframes each 0.2 s, LiDAR nodes at the same times; what the camera errs it is sure of to 2 mm.
class Drive {
 public:
  Drive(PoseGraph& graph, bool lidar) : graph_(graph), has_lidar_(lidar) {}

  void lidar(std::int64_t k) {
    if (has_lidar_) add(NodeKind::kLidar, k, k - 1, truth(k - 1).inverse() * truth(k), 0.005);
  }
  void keyframe(std::int64_t k, std::int64_t previous, const SE3& error) {
    add(NodeKind::kKeyframe, k, previous, truth(previous).inverse() * truth(k) * error, 0.002);
  }

 private:
  void add(NodeKind kind, std::int64_t k, std::int64_t previous, const SE3& T_step, double sigma) {
    NodeInput node;
    node.id = {kind, k};
    node.utime_us = k * kPeriod_us;
    node.previous_id = previous;
    node.T_previous_base = T_step;
    node.T_odom_base = truth(k);
    node.covariance = Matrix6d::Identity() * sigma * sigma;
    PoseInput pose;
    pose.sensor = kind;
    pose.utime_us = pose.fix_utime_us = node.utime_us;
    pose.T_odom_base = truth(k);
    pose.covariance = node.covariance;
    pose.state = PoseState::kOk;
    pose.reference = node.id;
    graph_.add_node(node);
    graph_.add_pose(pose);
  }

  PoseGraph& graph_;
  bool has_lidar_;
};

// It errs once, by 0.5 m and 0.2 rad.
struct Slip {
  PoseGraph graph;

  explicit Slip(bool lidar) {
    RobotModel robot;
    robot.has_camera = robot.planar = true;
    robot.has_lidar = lidar;
    graph.set_robot(robot);
    Drive drive(graph, lidar);
    for (std::int64_t k = 1; k <= 30; ++k) {
      drive.lidar(k);
      drive.keyframe(k, k - 1, k == 15 ? from_xyz_rpy(0.5, 0, 0, 0, 0, -0.2) : SE3::Identity());
    }
    graph.finish();
  }
};

TEST(SensorAgreement, AWrongEdgeOfTheCameraBendsNothingThatTheLidarSaw) {
  Slip both(true);
  EXPECT_EQ(both.graph.counts().edges_doubted, 1);
  for (std::int64_t k = 1; k <= 30; ++k) EXPECT_LT(error_m(both.graph, k), 0.02) << k;
  Slip alone(false);
  EXPECT_EQ(alone.graph.counts().edges_doubted, 0);
  EXPECT_GT(error_m(alone.graph, 30), 0.4);
}

// The camera is gone for 10 s (killed) and finds itself again in a place that looks alike.
struct Return {
  PoseGraph graph;
  static constexpr std::int64_t kLast = 90;

  Return(bool lidar, const SE3& error) {
    RobotModel robot;
    robot.has_camera = robot.planar = true;
    robot.has_lidar = lidar;
    graph.set_robot(robot);
    Drive drive(graph, lidar);
    for (std::int64_t k = 1; k <= kLast; ++k) {
      drive.lidar(k);
      if (k <= 30) drive.keyframe(k, k - 1, SE3::Identity());
      if (k == 80) drive.keyframe(k, 5, error);
      if (k > 80) drive.keyframe(k, k - 1, SE3::Identity());
    }
  }
};

TEST(SensorAgreement, WhereTheCameraFindsItselfAgainIsAskedOfTheGraph) {
  const SE3 elsewhere = from_xyz_rpy(-4.0, 3.0, 0, 0, 0, 3.0);
  Return wrong(true, elsewhere);
  EXPECT_EQ(wrong.graph.counts().edges_doubted, 1);
  for (std::int64_t k = 80; k <= Return::kLast; ++k) EXPECT_LT(error_m(wrong.graph, k), 0.05) << k;
  for (const PoseOutput& pose : wrong.graph.take_poses())
    EXPECT_LT((pose.T_map_base.translation() -
               (truth(1).inverse() * truth(pose.utime_us / kPeriod_us)).translation())
                  .norm(),
              0.05)
        << "not for a moment, at " << pose.utime_us;
  Return right(true, SE3::Identity());
  EXPECT_EQ(right.graph.counts().edges_doubted, 0);
  Return alone(false, elsewhere);
  EXPECT_EQ(alone.graph.counts().edges_doubted, 0) << "nobody to ask";
  EXPECT_GT(error_m(alone.graph, 85), 3.0);
}

}  // namespace
}  // namespace fusion_slam
