// Moving the whole map: nothing in it may change but where it is.
#include <cmath>

#include <gtest/gtest.h>

#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {
namespace {

NodeId keyframe(std::int64_t id) { return {NodeKind::kKeyframe, id}; }

// A camera in a hand: no two poses in one plane. Keyframe 1 is the map's origin.
PoseGraph carried(bool planar) {
  PoseGraph graph;
  RobotModel robot;
  robot.has_camera = true;
  robot.planar = planar;
  graph.set_robot(robot);
  for (std::int64_t id = 1; id <= 20; ++id) {
    const double i = static_cast<double>(id);
    NodeInput node;
    node.id = keyframe(id);
    node.utime_us = id * 100'000;
    node.previous_id = id - 1;
    node.T_previous_base =
        from_xyz_rpy(0.2, 0.05 * std::sin(i), 0.02, 0.05 * std::cos(i), 0.1, 0.2);
    node.covariance = Matrix6d::Identity() * 1e-5;
    graph.add_node(node);
    PoseInput pose;
    pose.utime_us = node.utime_us;
    pose.state = PoseState::kOk;
    pose.reference = node.id;
    graph.add_pose(pose);
  }
  graph.take_changes();
  graph.take_poses();
  return graph;
}

void expect_same_shape(const GraphNodes& a, const GraphNodes& b, double tolerance) {
  for (std::int64_t id = 2; id <= 20; ++id) {
    const auto relative = [&](const GraphNodes& nodes) {
      return nodes.at(keyframe(id - 1)).T_map_base.inverse() * nodes.at(keyframe(id)).T_map_base;
    };
    EXPECT_LT(local(relative(a), relative(b)).norm(), tolerance) << id;
  }
}

TEST(LevelMap, GivesZRollAndPitchAndKeepsEverythingElse) {
  PoseGraph graph = carried(false);
  const GraphNodes before = graph.nodes();
  const SE3 wished = from_xyz_rpy(5.0, -3.0, 1.38, 0.04, 0.51, 2.0);
  std::string why;
  ASSERT_TRUE(graph.level_map(keyframe(6), wished, &why)) << why;
  const SE3 T = graph.nodes().at(keyframe(6)).T_map_base;
  EXPECT_NEAR(T.translation().z(), 1.38, 1e-9);
  EXPECT_LT((T.linear().row(2) - wished.linear().row(2)).norm(), 1e-9);
  expect_same_shape(before, graph.nodes(), 1e-9);
  const SE3 origin = graph.nodes().at(keyframe(1)).T_map_base;  // was the identity
  EXPECT_LT(origin.translation().head<2>().norm(), 1e-12);
  EXPECT_EQ(graph.counts().levellings, 1);
}

TEST(LevelMap, HandsOutEveryNodeEvenWhenNothingMoved) {
  PoseGraph graph = carried(false);
  const std::int64_t revision = graph.revision();
  std::string why;
  const SE3 as_it_is = graph.nodes().at(keyframe(3)).T_map_base;
  ASSERT_TRUE(graph.level_map(keyframe(3), as_it_is, &why));
  EXPECT_EQ(graph.take_changes().size(), 20U);
  EXPECT_EQ(graph.revision(), revision + 1);
  EXPECT_TRUE(graph.nodes().at(keyframe(3)).T_map_base.isApprox(as_it_is, 1e-12));
}

TEST(LevelMap, StaysThroughNewNodesLoopsAndFinish) {
  PoseGraph graph = carried(false);
  std::string why;
  const SE3 wished = from_xyz_rpy(0.0, 0.0, 1.38, 0.04, 0.51, 0.0);
  ASSERT_TRUE(graph.level_map(keyframe(1), wished, &why));
  const GraphNodes levelled = graph.nodes();
  const auto relative =
      levelled.at(keyframe(2)).T_map_base.inverse() * levelled.at(keyframe(18)).T_map_base;
  graph.add_loop({keyframe(2), keyframe(18), relative, Matrix6d::Identity() * 1e-4, {}});
  NodeInput node;
  node.id = keyframe(21);
  node.utime_us = 2'100'000;
  node.previous_id = 20;
  node.T_previous_base = from_xyz_rpy(0.2, 0, 0, 0, 0, 0);
  graph.add_node(node);
  graph.finish();
  EXPECT_TRUE(
      graph.nodes().at(keyframe(1)).T_map_base.isApprox(levelled.at(keyframe(1)).T_map_base, 1e-9));
  expect_same_shape(levelled, graph.nodes(), 1e-6);
  const SE3 expected = graph.nodes().at(keyframe(20)).T_map_base * node.T_previous_base;
  EXPECT_TRUE(graph.nodes().at(keyframe(21)).T_map_base.isApprox(expected, 1e-6));
}

TEST(LevelMap, RefusesPlanarRobotsAndUnknownNodes) {
  PoseGraph planar = carried(true);
  std::string why;
  EXPECT_FALSE(planar.level_map(keyframe(1), from_xyz_rpy(0, 0, 1, 0, 0.5, 0), &why));
  EXPECT_NE(why.find("planar"), std::string::npos);
  EXPECT_TRUE(planar.nodes().at(keyframe(1)).T_map_base.isApprox(SE3::Identity()));
  PoseGraph graph = carried(false);
  EXPECT_FALSE(graph.level_map(keyframe(77), SE3::Identity(), &why));
  EXPECT_NE(why.find("77"), std::string::npos);
  PoseGraph nobody;
  EXPECT_FALSE(nobody.level_map(keyframe(1), SE3::Identity(), &why));
  EXPECT_NE(why.find("ROBOT_MODEL"), std::string::npos);
  EXPECT_EQ(graph.counts().levellings, 0);
}

}  // namespace
}  // namespace fusion_slam
