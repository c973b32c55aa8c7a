#include "services/pose_graph/global_bundle.hpp"

#include <gtest/gtest.h>

#include "tests/services/pose_graph/made_up_room.hpp"

namespace fusion_slam {
namespace {

SolveOptions anchored() {
  SolveOptions options;
  options.planar = true;
  options.anchor = MadeUpRoom::id(0);
  return options;
}

TEST(GlobalBundle, TakesTheDriftOutOfARound) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    MadeUpRoom room(40, 500, 0.01, 0.004, seed);
    const double before_m = room.worst_m(room.nodes);
    const BundleReport report =
        adjust_globally({}, anchored(), room.question, &room.nodes, &room.edges);
    ASSERT_TRUE(report.accepted) << report.reason;
    EXPECT_LT(report.final_cost, report.initial_cost);
    EXPECT_GT(before_m, 0.15);
    EXPECT_LT(room.worst_m(room.nodes), 0.05);
    for (const GraphEdge& edge : room.edges) {
      ASSERT_TRUE(edge.adjusted);
      EXPECT_LT(edge_error({}, true, room.nodes, edge), 1e-12);  // the graph keeps what it said
    }
  }
}

TEST(GlobalBundle, WrongMatchesAreOutvoted) {
  MadeUpRoom room(40, 500, 0.01, 0.004, 5);
  // A loop that takes walls for each other: forty pairs, all wrong.
  SamePoints wrong{3, 20, {}};
  for (int i = 0; i < 40; ++i) wrong.features.emplace_back(i, i);
  room.question.same.push_back(wrong);
  const BundleReport report =
      adjust_globally({}, anchored(), room.question, &room.nodes, &room.edges);
  EXPECT_TRUE(report.accepted) << report.reason;
  EXPECT_LT(room.worst_m(room.nodes), 0.03);
}

// LiDAR edges that all say otherwise: the bundle is refused and nothing has changed.
TEST(GlobalBundle, RefusesToContradictTheOtherSensor) {
  MadeUpRoom room(30, 400, 0.002, 0.001, 2);
  const auto lidar = [](std::size_t k) {
    return NodeId{NodeKind::kLidar, static_cast<std::int64_t>(k) + 1};
  };
  Matrix6d sure = Matrix6d::Identity() * 1e-6;
  // The camera is mounted 20 degrees otherwise than told, and the LiDAR knows where it goes.
  room.question.T_base_camera = room.question.T_base_camera * from_xyz_rpy(0, 0, 0, 0, 0.35, 0);
  room.edges.clear();
  for (std::size_t k = 0; k < room.truth.size(); ++k) {
    room.nodes[MadeUpRoom::id(k)].T_map_base = room.truth[k];
    room.nodes[lidar(k)].T_map_base = room.truth[k];
    room.edges.push_back({EdgeKind::kTie, lidar(k), MadeUpRoom::id(k), SE3::Identity(), sure, 1.0});
    if (k > 0)
      room.edges.push_back({EdgeKind::kLidar, lidar(k - 1), lidar(k),
                            SE3(room.truth[k - 1].inverse() * room.truth[k]), sure, 1.0});
  }
  PoseGraphConfig config;
  config.bundle.gate_chi2 = 0.01;  // nothing may move
  const GraphNodes before = room.nodes;
  const BundleReport report =
      adjust_globally(config, anchored(), room.question, &room.nodes, &room.edges);
  EXPECT_FALSE(report.accepted);
  EXPECT_NE(report.reason.find("contradicts"), std::string::npos) << report.reason;
  for (const auto& [id, node] : before)
    EXPECT_TRUE(node.T_map_base.isApprox(room.nodes.at(id).T_map_base, 0.0));
  for (const GraphEdge& edge : room.edges) EXPECT_FALSE(edge.adjusted);
}

TEST(GlobalBundle, SaysWhenThereIsTooLittleToGoBy) {
  MadeUpRoom room(10, 20, 0.01, 0.004, 1);
  const BundleReport report =
      adjust_globally({}, anchored(), room.question, &room.nodes, &room.edges);
  EXPECT_FALSE(report.accepted);
  EXPECT_NE(report.reason.find("points were seen twice"), std::string::npos) << report.reason;
}

TEST(GlobalBundle, TheSameBitsTwice) {
  MadeUpRoom a(30, 300, 0.01, 0.004, 4), b = a;
  adjust_globally({}, anchored(), a.question, &a.nodes, &a.edges);
  adjust_globally({}, anchored(), b.question, &b.nodes, &b.edges);
  for (const auto& [id, node] : a.nodes)
    EXPECT_EQ(node.T_map_base.matrix(), b.nodes.at(id).T_map_base.matrix());
}

}  // namespace
}  // namespace fusion_slam
