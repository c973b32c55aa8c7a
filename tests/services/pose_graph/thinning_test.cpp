// Nodes that older ones supersede: what is left of a long drive in the same place.
#include "services/pose_graph/thinning.hpp"

#include <gtest/gtest.h>

#include "libs/pose_manifold/relative_pose_cost.hpp"
#include "tests/services/pose_graph/rounds.hpp"

namespace fusion_slam {
namespace {

Matrix6d covariance(double m, double rad) {
  Vector6d variance;
  variance << m * m, 2.0 * m * m, 0.5 * m * m, rad * rad, 0.3 * rad * rad, 3.0 * rad * rad;
  Matrix6d all = variance.asDiagonal();
  all(0, 5) = all(5, 0) = 0.4 * m * rad;
  return all;
}

// The information about node 3 that is left when node 2 is eliminated from 1 - 2 - 3 is that of the
// edge 1 - 3 which takes their place.
TEST(Thinning, AChainIsComposedAsTheSchurComplementSays) {
  const PoseGraphConfig config;
  const SE3 T_1_2 = from_xyz_rpy(0.4, 0.1, 0.02, 0.05, -0.1, 0.6);
  const SE3 T_2_3 = from_xyz_rpy(0.3, -0.2, 0.0, -0.02, 0.04, -0.9);
  for (const bool second_reversed : {false, true}) {
    std::vector<GraphEdge> edges = {
        {EdgeKind::kVisual, node(1), node(2), T_1_2, covariance(0.01, 0.004), 1.0},
        {EdgeKind::kVisual, node(2), node(3), T_2_3, covariance(0.02, 0.003), 1.0}};
    if (second_reversed) {
      std::swap(edges[1].from, edges[1].to);
      edges[1].T_from_to = T_2_3.inverse();
    }
    const std::map<NodeId, SE3> at = {
        {node(1), SE3::Identity()}, {node(2), T_1_2}, {node(3), T_1_2 * T_2_3}};
    Eigen::Matrix<double, 12, 12> H = Eigen::Matrix<double, 12, 12>::Zero();  // of nodes 2 and 3
    for (const GraphEdge& edge : edges) {
      Matrix6d J[2];
      relative_pose_error(at.at(edge.from), at.at(edge.to), edge.T_from_to, &J[0], &J[1]);
      const Matrix6d information = effective_covariance(config.noise, edge, false).inverse();
      const NodeId ends[2] = {edge.from, edge.to};
      for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b)
          if (ends[a].id > 1 && ends[b].id > 1)
            H.block<6, 6>(6 * (ends[a].id - 2), 6 * (ends[b].id - 2)) +=
                J[a].transpose() * information * J[b];
    }
    const Matrix6d left = H.block<6, 6>(6, 6) -
                          H.block<6, 6>(6, 0) * H.block<6, 6>(0, 0).inverse() * H.block<6, 6>(0, 6);

    Thinning thinning(config, false, &edges);
    Retirement retirement{node(2), node(1), T_1_2, {}};
    ASSERT_TRUE(thinning.retire(&retirement));
    const auto number = thinning.finish();
    ASSERT_EQ(edges.size(), 1U);
    EXPECT_EQ(number, (std::vector<std::ptrdiff_t>{-1, 0}));
    Matrix6d J[2];
    const Vector6d error = relative_pose_error(at.at(edges[0].from), at.at(edges[0].to),
                                               edges[0].T_from_to, &J[0], &J[1]);
    EXPECT_LT(error.norm(), 1e-12);
    const Matrix6d& J_3 = edges[0].to == node(3) ? J[1] : J[0];
    const Matrix6d composed =
        J_3.transpose() * effective_covariance(config.noise, edges[0], false).inverse() * J_3;
    EXPECT_LT((composed - left).norm(), 1e-9 * left.norm());
  }
}

TEST(Thinning, OfTwoLoopsThatThenJoinTheSameNodesTheBetterStays) {
  const PoseGraphConfig config;
  const SE3 step = from_xyz_rpy(0.1, 0, 0, 0, 0, 0);
  std::vector<GraphEdge> edges = {
      {EdgeKind::kVisual, node(1), node(2), step, covariance(0.01, 0.004), 1.0},
      {EdgeKind::kLoop, node(1), node(9), step, covariance(0.05, 0.01), 1.0},
      {EdgeKind::kLoop, node(2), node(9), SE3::Identity(), covariance(0.01, 0.004), 1.0},
      {EdgeKind::kLoop, node(9), node(2), SE3::Identity(), covariance(0.03, 0.004), 1.0}};
  const double way = effective_covariance(config.noise, edges[0], false).trace();
  Thinning thinning(config, false, &edges);
  Retirement retirement{node(2), node(1), step, {}};
  ASSERT_TRUE(thinning.retire(&retirement));
  const auto number = thinning.finish();
  EXPECT_EQ(number, (std::vector<std::ptrdiff_t>{-1, 0, 1, -1}));
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_EQ(edges[1].from, node(1));
  EXPECT_EQ(edges[1].said_from, node(2)) << "reports name the loop as it was found";
  EXPECT_TRUE(edges[1].T_from_to.isApprox(step, 1e-12));
  EXPECT_GT(effective_covariance(config.noise, edges[1], false).trace(), way)
      << "no more certain than the way to its carrier";
}

TEST(Thinning, ManyRoundsStayWhereTheWholeGraphPutsThem) {
  constexpr int kNodes = 15 * Rounds::kPerRound;
  const Rounds rounds(kNodes);
  PoseGraph thinned = camera_graph(true), whole = camera_graph(false);
  for (PoseGraph* graph : {&thinned, &whole}) {
    rounds.feed(graph, 0, kNodes);
    graph->finish();
  }
  EXPECT_EQ(whole.counts().retired, 0);
  EXPECT_GT(thinned.counts().retired, 100);
  EXPECT_EQ(thinned.counts().loops, whole.counts().loops);
  const auto poses = all_poses(thinned);
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(kNodes));
  for (const auto& [id, T] : poses) {
    const Vector6d off = local(whole.nodes().at(id).T_map_base, T);
    const bool stays = thinned.nodes().count(id) > 0;
    EXPECT_LT(off.head<3>().norm(), stays ? 0.003 : 0.006) << id.id;
    EXPECT_LT(off.tail<3>().norm(), stays ? 0.002 : 0.004) << id.id;
  }
}

TEST(Thinning, TheGraphStopsGrowing) {
  const Rounds rounds(50 * Rounds::kPerRound);
  PoseGraph graph = camera_graph(true);
  std::size_t nodes = 0, edges = 0;
  for (int round = 0; round < 50; ++round) {
    rounds.feed(&graph, round * Rounds::kPerRound, (round + 1) * Rounds::kPerRound);
    graph.take_changes();
    if (round < 15) {
      nodes = std::max(nodes, graph.nodes().size());
      edges = std::max(edges, graph.edges().size());
    }
    EXPECT_LE(graph.nodes().size(), nodes) << "round " << round;
    EXPECT_LE(graph.edges().size(), edges + edges / 5) << "round " << round;
  }
  EXPECT_EQ(graph.n_nodes(), static_cast<std::size_t>(50 * Rounds::kPerRound));
  EXPECT_LT(graph.nodes().size(), 260U);
}

TEST(Thinning, NothingRetiresInFewRoundsOrOnNewGround) {
  const Rounds rounds(5 * Rounds::kPerRound);
  PoseGraph graph = camera_graph(true);
  rounds.feed(&graph, 0, 5 * Rounds::kPerRound);
  EXPECT_EQ(graph.counts().retired, 0);

  PoseGraph straight = camera_graph(true);
  for (int i = 1; i <= 1000; ++i) {
    NodeInput input;
    input.id = node(i);
    input.utime_us = i * 1'000'000;
    input.previous_id = i - 1;
    input.T_previous_base = from_xyz_rpy(0.3, 0, 0, 0, 0, 0);
    input.covariance = Matrix6d::Identity() * 1e-6;
    straight.add_node(input);
  }
  EXPECT_EQ(straight.counts().retired, 0);
  EXPECT_EQ(straight.edges().size(), 999U);
}

TEST(Thinning, ARestartRetiresTheSameNodes) {
  constexpr int kNodes = 12 * Rounds::kPerRound;
  const Rounds rounds(kNodes + 20);
  PoseGraph graph = camera_graph(true);
  PoseGraph::Earlier earlier;
  for (int i = 0; i < kNodes; ++i) {
    rounds.feed(&graph, i, i + 1);
    for (const auto& [id, at] : graph.take_changes()) earlier.T_map_base[id] = at.T_map_base;
    for (const auto& [n, r] : graph.take_retirements()) earlier.retired[n].push_back(r);
  }
  ASSERT_GT(graph.counts().retired, 50);
  PoseGraph again = camera_graph(true);
  again.rebuild(earlier);
  rounds.feed(&again, 0, kNodes);
  again.finish();
  EXPECT_EQ(again.counts().solves, 0) << "an earlier process has solved it";
  again.rebuilt();
  EXPECT_TRUE(again.take_retirements().empty());
  EXPECT_EQ(again.counts().retired, graph.counts().retired);
  ASSERT_EQ(again.edges().size(), graph.edges().size());
  for (std::size_t i = 0; i < graph.edges().size(); ++i) {
    EXPECT_EQ(again.edges()[i].from, graph.edges()[i].from);
    EXPECT_EQ(again.edges()[i].to, graph.edges()[i].to);
    EXPECT_TRUE(again.edges()[i].T_from_to.isApprox(graph.edges()[i].T_from_to, 1e-9));
  }
  for (int more = kNodes; more < kNodes + 20; ++more)
    for (PoseGraph* g : {&graph, &again}) rounds.feed(g, more, more + 1);
  for (PoseGraph* g : {&graph, &again}) g->finish();
  const auto poses = all_poses(graph), poses_again = all_poses(again);
  ASSERT_EQ(poses.size(), poses_again.size());
  for (const auto& [id, T] : poses) EXPECT_LT(local(T, poses_again.at(id)).norm(), 0.004) << id.id;
}

}  // namespace
}  // namespace fusion_slam
