#include "services/pose_graph/pose_graph.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

constexpr std::int64_t kFrameUs = 33'333;
constexpr std::int64_t kScanUs = 100'000;

Matrix6d small() { return Matrix6d::Identity() * 1e-5; }

// The robot drives a circle of 2 m radius in 20 s.
SE3 truth(std::int64_t utime_us) {
  const double angle = 2.0 * M_PI * static_cast<double>(utime_us) * 1e-6 / 20.0;
  return from_xyz_rpy(2.0 * std::sin(angle), 2.0 * (1.0 - std::cos(angle)), 0, 0, 0, angle);
}

RobotModel robot(bool camera, bool lidar) {
  RobotModel model;
  model.has_camera = camera;
  model.has_lidar = lidar;
  return model;
}

// A tracker of one sensor that makes every n-th measurement a node; drift_rad is added to each
// edge's yaw.
struct Tracker {
  NodeKind kind;
  std::int64_t period_us;
  int per_node;
  double drift_rad = 0.0;
  std::int64_t first_us = 0;
  int count = 0;
  std::int64_t nodes = 0;
  std::int64_t node_utime_us = 0;
  SE3 T_odom_node = SE3::Identity();
  bool pose_first = false;
  std::int64_t clock_us = 0;  // what the clock is ahead of the truth

  void step(PoseGraph* graph) {
    const std::int64_t t = first_us + count * period_us;
    SE3 T_node_base = truth(node_utime_us).inverse() * truth(t);
    NodeInput node;
    const bool is_node = count % per_node == 0;
    if (is_node) {
      T_node_base = T_node_base * from_xyz_rpy(0, 0, 0, 0, 0, nodes > 0 ? drift_rad : 0.0);
      node.previous_id = nodes;
      node.id = {kind, ++nodes};
      node.utime_us = t + clock_us;
      node.T_previous_base = T_node_base;
      node.covariance = small();
      T_odom_node = nodes == 1 ? SE3::Identity() : T_odom_node * T_node_base;
      node.T_odom_base = T_odom_node;
      node_utime_us = t;
      T_node_base = SE3::Identity();
    }
    PoseInput pose;
    pose.sensor = kind;
    pose.utime_us = t + clock_us;
    pose.state = PoseState::kOk;
    pose.reference = NodeId{kind, nodes};
    pose.T_reference_base = T_node_base;
    pose.T_odom_base = T_odom_node * T_node_base;
    pose.covariance = small();
    pose.fix_utime_us = t + clock_us;
    if (pose_first) graph->add_pose(pose);
    if (is_node) graph->add_node(node);
    if (!pose_first) graph->add_pose(pose);
    ++count;
  }
};

void run(PoseGraph* graph, Tracker* a, Tracker* b, std::int64_t until_us) {
  for (;;) {
    const std::int64_t ta = a->first_us + a->count * a->period_us;
    const std::int64_t tb = b == nullptr ? INT64_MAX : b->first_us + b->count * b->period_us;
    if (std::min(ta, tb) > until_us) return;
    (ta <= tb ? a : b)->step(graph);
  }
}

double worst_error_m(const std::vector<PoseOutput>& poses, std::int64_t origin_us) {
  double worst = 0.0;
  for (const PoseOutput& p : poses)
    worst = std::max(worst, (p.T_map_base.translation() -
                             (truth(origin_us).inverse() * truth(p.utime_us)).translation())
                                .norm());
  return worst;
}

TEST(PoseGraph, OneSensorIsItsChain) {
  for (const NodeKind kind : {NodeKind::kKeyframe, NodeKind::kLidar}) {
    PoseGraph graph;
    graph.set_robot(robot(kind == NodeKind::kKeyframe, kind == NodeKind::kLidar));
    Tracker tracker{kind, kFrameUs, 5};
    run(&graph, &tracker, nullptr, 5'000'000);
    const auto poses = graph.take_poses();
    EXPECT_EQ(poses.size(), static_cast<std::size_t>(tracker.count));
    EXPECT_LT(worst_error_m(poses, 0), 1e-9);
    EXPECT_TRUE(graph.nodes().begin()->second.T_map_base.isApprox(SE3::Identity()));
    graph.take_changes();
    graph.finish();
    EXPECT_TRUE(graph.take_changes().empty());  // a chain that agrees with itself stays where it is
  }
}

// The same times come again, at other places: nothing of then is taken for now.
TEST(PoseGraph, AClockThatIsSetBackBendsNothing) {
  PoseGraph graph;
  graph.set_robot(robot(true, true));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 5};
  Tracker lidar{NodeKind::kLidar, kScanUs, 4};
  run(&graph, &camera, &lidar, 8'000'000);
  camera.clock_us = lidar.clock_us = -5'000'000;
  graph.clock_was_set_back(3'000'000);
  run(&graph, &camera, &lidar, 12'000'000);
  graph.finish();
  EXPECT_EQ(graph.counts().restarts, 0);
  for (const auto& [id, node] : graph.nodes()) {
    const Tracker& tracker = id.kind == NodeKind::kKeyframe ? camera : lidar;
    const SE3 expected = truth((id.id - 1) * tracker.per_node * tracker.period_us);
    EXPECT_LT((node.T_map_base.translation() - expected.translation()).norm(), 0.01) << id.id;
  }
}

TEST(PoseGraph, OrderWithinOneTimeDoesNotMatter) {
  PoseGraph node_first;
  PoseGraph pose_first;
  Tracker a{NodeKind::kKeyframe, kFrameUs, 5};
  Tracker b = a;
  b.pose_first = true;
  run(&node_first, &a, nullptr, 3'000'000);
  run(&pose_first, &b, nullptr, 3'000'000);
  const auto poses_a = node_first.take_poses();
  const auto poses_b = pose_first.take_poses();
  ASSERT_EQ(poses_a.size(), poses_b.size());
  for (std::size_t i = 0; i < poses_a.size(); ++i) {
    EXPECT_EQ(poses_a[i].utime_us, poses_b[i].utime_us);
    EXPECT_TRUE(poses_a[i].T_map_base.isApprox(poses_b[i].T_map_base, 0.0));
  }
}

// The LiDAR starts 40 ms after the camera: its first node is hung into the camera's trajectory.
TEST(PoseGraph, TwoSensorsShareOneMap) {
  PoseGraph graph;
  graph.set_robot(robot(true, true));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 5};
  Tracker lidar{NodeKind::kLidar, kScanUs, 2};
  lidar.first_us = 40'000;
  lidar.node_utime_us = 40'000;
  run(&graph, &camera, &lidar, 10'000'000);
  EXPECT_GT(graph.counts().ties, 40);
  EXPECT_EQ(graph.counts().restarts, 0);
  graph.finish();
  const auto poses = graph.take_poses();
  EXPECT_EQ(poses.size(), static_cast<std::size_t>(camera.count + lidar.count));
  EXPECT_LT(worst_error_m(poses, 0), 0.01);  // the interpolated arc
}

TEST(PoseGraph, TiesHoldADriftingSensorToTheOther) {
  PoseGraph graph;
  graph.set_robot(robot(true, true));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 5, 0.003};
  Tracker lidar{NodeKind::kLidar, kScanUs, 2, -0.003};
  run(&graph, &camera, &lidar, 10'000'000);
  graph.take_poses();
  graph.finish();
  // Camera and LiDAR drift in opposite ways; both chains are one trajectory in the graph.
  for (const auto& [id, node] : graph.nodes()) {
    if (id.kind != NodeKind::kKeyframe) continue;
    for (const auto& [other, lidar_node] : graph.nodes()) {
      if (other.kind == NodeKind::kLidar && std::abs(lidar_node.utime_us - node.utime_us) < 1'000) {
        EXPECT_LT((lidar_node.T_map_base.translation() - node.T_map_base.translation()).norm(),
                  0.02);
      }
    }
  }
}

TEST(PoseGraph, ALoopClosesTheCircle) {
  PoseGraph graph;
  graph.set_robot(robot(true, false));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 10, 0.002};
  run(&graph, &camera, nullptr, 20'000'000);
  const NodeId first{NodeKind::kKeyframe, 1};
  const NodeId last{NodeKind::kKeyframe, camera.nodes};
  const std::int64_t last_us = graph.nodes().at(last).utime_us;
  const auto error_m = [&] {
    return (graph.nodes().at(last).T_map_base.translation() - truth(last_us).translation()).norm();
  };
  const double before_m = error_m();
  graph.take_changes();
  const std::int64_t revision = graph.revision();
  graph.add_loop({first, last, truth(last_us), Matrix6d::Identity() * 1e-6, {}});
  graph.finish();
  EXPECT_LT(error_m(), 0.2 * before_m);
  EXPECT_GT(graph.take_changes().size(), 10U);
  EXPECT_GT(graph.revision(), revision);
  EXPECT_EQ(graph.counts().loops_outvoted, 0);
}

// POSE's covariance is that of the map: it grows along the way, along the edges, and a loop says
// that the robot is near its start again.
TEST(PoseGraph, CovarianceGrowsAlongTheWayAndALoopEndsIt) {
  PoseGraph graph;
  graph.set_robot(robot(true, false));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 10};
  run(&graph, &camera, nullptr, 20'000'000);
  const auto poses = graph.take_poses();
  const auto sigma2 = [](const PoseOutput& pose) {
    return pose.covariance.topLeftCorner<2, 2>().trace();
  };
  double expected = 0.0;  // translation alone, by hand: a lower bound
  for (const GraphEdge& edge : graph.edges())
    expected += effective_covariance({}, edge, true).topLeftCorner<2, 2>().trace();
  EXPECT_LT(sigma2(poses.front()), 1e-4);
  EXPECT_GT(sigma2(poses[poses.size() / 2]), sigma2(poses[poses.size() / 4]));
  EXPECT_GT(sigma2(poses.back()), expected);
  const NodeId first{NodeKind::kKeyframe, 1};
  const NodeId last{NodeKind::kKeyframe, camera.nodes};
  graph.add_loop(
      {first, last, truth(graph.nodes().at(last).utime_us), Matrix6d::Identity() * 1e-6, {}});
  graph.finish();
  camera.step(&graph);
  EXPECT_LT(sigma2(graph.take_poses().back()), 0.1 * sigma2(poses.back()));
}

// Three true loops and one that a hand put in: it is switched off, said so, and the map is as if it
// had never been.
TEST(PoseGraph, AWrongLoopIsSwitchedOffAndReported) {
  PoseGraph graph;
  graph.set_robot(robot(true, false));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 10, 0.002};
  run(&graph, &camera, nullptr, 20'000'000);
  const auto node = [](std::int64_t id) { return NodeId{NodeKind::kKeyframe, id}; };
  const auto true_motion = [&](std::int64_t a, std::int64_t b) {
    return SE3(truth(graph.nodes().at(node(a)).utime_us).inverse() *
               truth(graph.nodes().at(node(b)).utime_us));
  };
  const Matrix6d sure = Matrix6d::Identity() * 1e-4;
  for (const std::int64_t back : {0, 3, 6})
    graph.add_loop({node(1 + back),
                    node(camera.nodes - back),
                    true_motion(1 + back, camera.nodes - back),
                    sure,
                    {}});
  graph.finish();
  const SE3 before = graph.nodes().at(node(camera.nodes)).T_map_base;
  graph.add_loop({node(2),
                  node(camera.nodes - 1),
                  SE3(true_motion(2, camera.nodes - 1) * from_xyz_rpy(3.0, 1.0, 0, 0, 0, 0.4)),
                  sure,
                  {}});
  graph.finish();
  ASSERT_EQ(graph.switched_off().size(), 1U);
  EXPECT_EQ(graph.switched_off()[0].from, node(2));
  EXPECT_EQ(graph.switched_off()[0].to, node(camera.nodes - 1));
  EXPECT_GT(graph.switched_off()[0].squared_error, 16.8);
  EXPECT_NE(graph.switched_off()[0].reason.find("all other edges"), std::string::npos);
  const SE3 after = graph.nodes().at(node(camera.nodes)).T_map_base;
  EXPECT_LT((after.translation() - before.translation()).norm(), 0.02);
}

// Each whole solve moves the newest nodes by a product of three poses: without care the rounding
// errors of their rotations triple each time, and after forty solves they are no rotations.
TEST(PoseGraph, RotationsStayRotationsAfterManySolves) {
  PoseGraph graph;
  graph.set_robot(robot(true, false));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 10, 0.0005};
  const auto node = [](std::int64_t id) { return NodeId{NodeKind::kKeyframe, id}; };
  run(&graph, &camera, nullptr, 1'000'000);
  for (std::int64_t k = 1; k <= 60; ++k) {  // two stories in turn: no solve satisfies both
    const SE3 T = truth(graph.nodes().at(node(1)).utime_us).inverse() *
                  truth(graph.nodes().at(node(camera.nodes)).utime_us) *
                  from_xyz_rpy(k % 2 == 0 ? 0.5 : -0.5, 0, 0, 0, 0, 0);
    graph.add_loop({node(1), node(camera.nodes), T, Matrix6d::Identity() * 1e-4, {}});
    run(&graph, &camera, nullptr, 1'000'000 + k * 1'200'000);
  }
  EXPECT_GT(graph.counts().solves, 100);
  for (const auto& [id, at] : graph.nodes()) {
    const Eigen::Matrix3d R = at.T_map_base.linear();
    EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-12)
        << id.id;
  }
}

TEST(PoseGraph, ALoopWaitsForItsNodes) {
  PoseGraph graph;
  graph.add_loop(
      {{NodeKind::kKeyframe, 1}, {NodeKind::kKeyframe, 3}, SE3::Identity(), small(), {}});
  EXPECT_EQ(graph.counts().loops, 0);
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 1};
  run(&graph, &camera, nullptr, 200'000);
  EXPECT_EQ(graph.counts().loops, 1);
  graph.add_loop(
      {{NodeKind::kKeyframe, 1}, {NodeKind::kKeyframe, 1}, SE3::Identity(), small(), {}});
  EXPECT_EQ(graph.counts().rejected, 1);
}

// The camera is lost for a second and starts a new chain; the LiDAR drives on.
TEST(PoseGraph, TheLidarBridgesALostCamera) {
  PoseGraph graph;
  graph.set_robot(robot(true, true));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 5};
  Tracker lidar{NodeKind::kLidar, kScanUs, 2};
  run(&graph, &camera, &lidar, 4'000'000);
  graph.take_poses();
  PoseInput lost;
  lost.state = PoseState::kLost;
  lost.reason = "too few matches";
  while (camera.first_us + camera.count * kFrameUs < 5'000'000) {
    const std::int64_t t = camera.first_us + camera.count * kFrameUs;
    while (lidar.first_us + lidar.count * kScanUs <= t) lidar.step(&graph);
    lost.utime_us = t;
    graph.add_pose(lost);
    ++camera.count;
  }
  const auto bridged = graph.take_poses();
  ASSERT_GT(bridged.size(), 20U);
  for (const PoseOutput& p : bridged) EXPECT_NE(p.state, PoseState::kLost);
  EXPECT_LT(worst_error_m(bridged, 0), 0.10);  // the newest scan's pose is at most 0.1 s old

  // Anew: previous_id 0, and the tracker's odometry frame starts from identity.
  Tracker anew{NodeKind::kKeyframe, kFrameUs, 5};
  anew.first_us = camera.first_us + camera.count * kFrameUs;
  anew.node_utime_us = anew.first_us;
  anew.nodes = 1000;
  const std::int64_t t = anew.first_us;
  NodeInput node;
  node.id = {NodeKind::kKeyframe, 1001};
  node.utime_us = t;
  graph.add_node(node);
  anew.nodes = 1001;
  anew.count = 1;
  run(&graph, &anew, &lidar, 7'000'000);
  EXPECT_EQ(graph.counts().restarts, 0);
  graph.finish();
  graph.take_poses();
  const SE3 T = graph.nodes().at({NodeKind::kKeyframe, 1001}).T_map_base;
  EXPECT_LT((T.translation() - truth(t).translation()).norm(), 0.02);
}

TEST(PoseGraph, ALostLonelyCameraGoesOnFromItsLastPose) {
  PoseGraph graph;
  graph.set_robot(robot(true, false));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 5};
  run(&graph, &camera, nullptr, 2'000'000);
  const PoseOutput last = graph.take_poses().back();
  PoseInput lost;
  lost.utime_us = last.utime_us + kFrameUs;
  lost.state = PoseState::kLost;
  lost.reason = "dark";
  graph.add_pose(lost);
  const auto said = graph.take_poses();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].state, PoseState::kLost);
  EXPECT_EQ(said[0].reason, "dark");
  EXPECT_TRUE(said[0].T_map_base.isApprox(last.T_map_base, 1e-12));

  NodeInput node;
  node.id = {NodeKind::kKeyframe, 99};
  node.utime_us = lost.utime_us + kFrameUs;
  node.T_odom_base = camera.T_odom_node * last.T_reference_base * from_xyz_rpy(0.1, 0, 0, 0, 0, 0);
  graph.add_node(node);
  EXPECT_EQ(graph.counts().restarts, 1);
  const SE3 expected = last.T_map_base * from_xyz_rpy(0.1, 0, 0, 0, 0, 0);
  EXPECT_TRUE(graph.nodes().at(node.id).T_map_base.isApprox(expected, 1e-9));
}

TEST(PoseGraph, WheelsCarryARestart) {
  PoseGraph graph;
  graph.set_robot(robot(true, false));
  for (std::int64_t t = 0; t <= 4'000'000; t += 20'000) graph.add_odometry(t, truth(t));
  Tracker camera{NodeKind::kKeyframe, kFrameUs, 5};
  run(&graph, &camera, nullptr, 2'000'000);
  NodeInput node;
  node.id = {NodeKind::kKeyframe, 99};
  node.utime_us = 3'500'000;
  graph.add_node(node);
  const SE3 T = graph.nodes().at(node.id).T_map_base;
  EXPECT_LT((T.translation() - truth(node.utime_us).translation()).norm(), 0.01);
  EXPECT_EQ(graph.edges().back().kind, EdgeKind::kOdometry);
}

TEST(PoseGraph, ANodeWhosePreviousNeverCameIsNotLost) {
  PoseGraph graph;
  graph.set_robot(robot(false, true));
  Tracker lidar{NodeKind::kLidar, kScanUs, 1};
  run(&graph, &lidar, nullptr, 1'000'000);
  ++lidar.nodes;  // as if the message of this node was lost
  ++lidar.count;
  lidar.node_utime_us = lidar.count * kScanUs - kScanUs;
  lidar.T_odom_node = truth(lidar.node_utime_us);
  run(&graph, &lidar, nullptr, 5'000'000);
  EXPECT_GT(graph.nodes().size(), 40U);
  EXPECT_EQ(graph.counts().restarts, 1);
  graph.finish();
  const auto& last = *graph.nodes().rbegin();
  EXPECT_LT(
      (last.second.T_map_base.translation() - truth(last.second.utime_us).translation()).norm(),
      0.05);
}

TEST(PoseGraph, ADuplicateNodeIsRejected) {
  PoseGraph graph;
  NodeInput node;
  node.id = {NodeKind::kLidar, 1};
  graph.add_node(node);
  graph.add_node(node);
  EXPECT_EQ(graph.nodes().size(), 1U);
  EXPECT_EQ(graph.counts().rejected, 1);
}

}  // namespace
}  // namespace fusion_slam
