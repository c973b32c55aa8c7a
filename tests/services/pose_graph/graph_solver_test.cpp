#include "services/pose_graph/graph_solver.hpp"

#include <random>

#include <gtest/gtest.h>

#include "services/pose_graph/sparse_problem.hpp"

namespace fusion_slam {
namespace {

Matrix6d covariance(double translation_m, double rotation_rad) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(translation_m * translation_m),
      Eigen::Vector3d::Constant(rotation_rad * rotation_rad);
  return d.asDiagonal();
}

NodeId keyframe(std::int64_t id) { return {NodeKind::kKeyframe, id}; }

GraphEdge edge(EdgeKind kind, std::int64_t from, std::int64_t to, const SE3& T) {
  return {kind, keyframe(from), keyframe(to), T, covariance(0.02, 0.01), 1.0};
}

SE3 random_pose(std::mt19937& rng, double translation_m, double rotation_rad) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  return from_xyz_rpy(translation_m * u(rng), translation_m * u(rng), translation_m * u(rng),
                      rotation_rad * u(rng), rotation_rad * u(rng), rotation_rad * u(rng));
}

struct Truth {
  std::vector<SE3> poses;
  GraphNodes nodes;
  std::vector<GraphEdge> edges;
};

// A closed square of 4 * side steps of 0.5 m, 90 degree corners; measured with noise, poses by dead
// reckoning.
Truth square(int side, double noise_m, double noise_rad, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> gauss(0.0, 1.0);
  Truth truth;
  SE3 T = SE3::Identity();
  for (int i = 0; i < 4 * side; ++i) {
    truth.poses.push_back(T);
    T = T * from_xyz_rpy(0.5, 0, 0, 0, 0, i % side == side - 1 ? M_PI / 2 : 0.0);
  }
  SE3 dead = SE3::Identity();
  for (int i = 0; i < 4 * side; ++i) {
    if (i > 0) {
      Vector6d noise;
      for (int k = 0; k < 6; ++k) noise[k] = gauss(rng) * (k < 3 ? noise_m : noise_rad);
      const SE3 step = retract(truth.poses[i - 1].inverse() * truth.poses[i], noise);
      truth.edges.push_back(edge(EdgeKind::kVisual, i, i + 1, step));
      dead = dead * step;
    }
    truth.nodes[keyframe(i + 1)].T_map_base = dead;
  }
  return truth;
}

double worst_error_m(const Truth& truth) {
  double worst = 0.0;
  for (std::size_t i = 0; i < truth.poses.size(); ++i)
    worst = std::max(
        worst,
        (truth.nodes.at(keyframe(static_cast<std::int64_t>(i) + 1)).T_map_base.translation() -
         truth.poses[i].translation())
            .norm());
  return worst;
}

SolveOptions anchored() {
  SolveOptions options;
  options.anchor = keyframe(1);
  return options;
}

// Four nodes on a line, each step measured as 1 m, the whole as 3.04 m: the answer can be written
// down.
TEST(GraphSolver, KnownAnswerOnALine) {
  PoseGraphConfig config;
  config.noise.visual_optimism = 1.0;
  config.noise.floor_translation_m = 0.0;
  config.noise.floor_rotation_rad = 0.0;
  GraphNodes nodes;
  std::vector<GraphEdge> edges;
  for (int i = 1; i <= 4; ++i) nodes[keyframe(i)].T_map_base = from_xyz_rpy(i - 1, 0, 0, 0, 0, 0);
  for (int i = 1; i <= 3; ++i)
    edges.push_back(edge(EdgeKind::kVisual, i, i + 1, from_xyz_rpy(1, 0, 0, 0, 0, 0)));
  edges.push_back(edge(EdgeKind::kVisual, 1, 4, from_xyz_rpy(3.04, 0, 0, 0, 0, 0)));
  ASSERT_TRUE(solve_graph(config, anchored(), &nodes, &edges).usable);
  // Equal variances: the chain of 3 (variance 3) and the direct edge (variance 1) share 0.04 m as 3
  // : 1.
  EXPECT_NEAR(nodes[keyframe(4)].T_map_base.translation().x(), 3.03, 1e-6);
  EXPECT_NEAR(nodes[keyframe(2)].T_map_base.translation().x(), 1.01, 1e-6);
}

TEST(GraphSolver, NoiseFreeRandomGraphsGiveExactPoses) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937 rng(seed);
    std::vector<SE3> poses{SE3::Identity()};
    GraphNodes nodes;
    std::vector<GraphEdge> edges;
    nodes[keyframe(1)] = {};
    for (int i = 1; i < 40; ++i) {
      poses.push_back(poses.back() * random_pose(rng, 0.5, 0.5));
      nodes[keyframe(i + 1)].T_map_base = poses.back() * random_pose(rng, 0.3, 0.3);
      edges.push_back(edge(EdgeKind::kVisual, i, i + 1, poses[i - 1].inverse() * poses[i]));
    }
    for (int loop = 0; loop < 10; ++loop) {
      const int a = static_cast<int>(rng() % 20);
      const int b = 20 + static_cast<int>(rng() % 20);
      edges.push_back(edge(EdgeKind::kLoop, a + 1, b + 1, poses[a].inverse() * poses[b]));
    }
    const SolveReport report = solve_graph({}, anchored(), &nodes, &edges);
    ASSERT_TRUE(report.usable);
    EXPECT_EQ(report.loops_outvoted, 0);
    for (std::size_t i = 0; i < poses.size(); ++i)
      EXPECT_TRUE(
          nodes[keyframe(static_cast<std::int64_t>(i) + 1)].T_map_base.isApprox(poses[i], 1e-5))
          << "seed " << seed << " node " << i;
  }
}

TEST(GraphSolver, ALoopRemovesDrift) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Truth truth = square(25, 0.01, 0.005, seed);
    const double before_m = worst_error_m(truth);
    truth.edges.push_back(
        edge(EdgeKind::kLoop, 100, 1, truth.poses[99].inverse() * truth.poses[0]));
    const SolveReport report = solve_graph({}, anchored(), &truth.nodes, &truth.edges);
    EXPECT_EQ(report.loops_outvoted, 0) << "seed " << seed;
    EXPECT_LT(worst_error_m(truth), 0.8 * before_m) << "seed " << seed;
    EXPECT_TRUE(
        local(truth.edges.back().T_from_to,
              truth.nodes[keyframe(100)].T_map_base.inverse() * truth.nodes[keyframe(1)].T_map_base)
            .head<3>()
            .norm() < 0.05);
  }
}

TEST(GraphSolver, AWrongLoopIsOutvoted) {
  Truth truth = square(25, 0.005, 0.002, 7);
  truth.edges.push_back(edge(EdgeKind::kLoop, 100, 1, truth.poses[99].inverse() * truth.poses[0]));
  Truth with_wrong = truth;
  // Claims that node 60, on the far side, is where node 10 is, facing the other way.
  with_wrong.edges.push_back(edge(EdgeKind::kLoop, 10, 60, from_xyz_rpy(0, 0, 0, 0, 0, M_PI)));
  solve_graph({}, anchored(), &truth.nodes, &truth.edges);
  const SolveReport report = solve_graph({}, anchored(), &with_wrong.nodes, &with_wrong.edges);
  EXPECT_EQ(report.loops_outvoted, 1);
  EXPECT_LT(with_wrong.edges.back().loop_weight, 0.1);
  EXPECT_GT(with_wrong.edges[with_wrong.edges.size() - 2].loop_weight, 0.5);
  for (const auto& [id, node] : truth.nodes)
    EXPECT_LT(
        (node.T_map_base.translation() - with_wrong.nodes.at(id).T_map_base.translation()).norm(),
        0.01);
}

TEST(GraphSolver, OnlyTheWindowMoves) {
  Truth truth = square(5, 0.02, 0.01, 3);
  const GraphNodes before = truth.nodes;
  truth.edges.push_back(
      edge(EdgeKind::kVisual, 10, 20, truth.poses[9].inverse() * truth.poses[19]));
  SolveOptions options = anchored();
  for (int i = 16; i <= 20; ++i) options.moving.insert(keyframe(i));
  ASSERT_TRUE(solve_graph({}, options, &truth.nodes, &truth.edges).usable);
  for (const auto& [id, node] : truth.nodes) {
    const bool moved = !node.T_map_base.isApprox(before.at(id).T_map_base, 1e-12);
    EXPECT_EQ(moved, id.id >= 16) << id.id;
  }
}

TEST(GraphSolver, APlanarRobotIsPutBackOnItsFloor) {
  Truth truth = square(10, 0.0, 0.004, 5);
  SolveOptions options = anchored();
  options.planar = true;
  solve_graph({}, options, &truth.nodes, &truth.edges);
  for (const auto& [id, node] : truth.nodes)
    EXPECT_LT(std::abs(node.T_map_base.translation().z()), 0.02) << id.id;
}

TEST(GraphSolver, WhatNobodyWantsAnyMoreEndsAndChangesNothing) {
  Truth truth = square(5, 0.02, 0.01, 4);
  truth.edges.push_back(edge(EdgeKind::kLoop, 1, 20, truth.poses[0].inverse() * truth.poses[19]));
  const GraphNodes before = truth.nodes;
  SolveOptions options;
  options.anchor = keyframe(1);
  const auto unwanted = std::make_shared<std::atomic<bool>>(true);
  options.unwanted = unwanted;
  SolveReport report = solve_graph({}, options, &truth.nodes, &truth.edges);
  EXPECT_FALSE(report.usable);
  EXPECT_EQ(report.iterations, 0);
  for (const auto& [id, node] : before)
    EXPECT_EQ(truth.nodes.at(id).T_map_base.matrix(), node.T_map_base.matrix());
  *unwanted = false;
  report = solve_graph({}, options, &truth.nodes, &truth.edges);
  EXPECT_TRUE(report.usable);
  EXPECT_GT(report.iterations, 0);
}

TEST(GraphSolver, TwoRunsGiveTheSameBits) {
  const auto run = [] {
    Truth truth = square(25, 0.01, 0.005, 11);
    truth.edges.push_back(
        edge(EdgeKind::kLoop, 100, 1, truth.poses[99].inverse() * truth.poses[0]));
    const std::vector<int> heap_noise(12345);  // other addresses, same answer
    solve_graph({}, anchored(), &truth.nodes, &truth.edges);
    return truth.nodes;
  };
  const GraphNodes a = run();
  const std::vector<std::vector<int>> more_heap_noise(77, std::vector<int>(131));
  const GraphNodes b = run();
  for (const auto& [id, node] : a)
    EXPECT_TRUE((node.T_map_base.matrix().array() == b.at(id).T_map_base.matrix().array()).all());
}

TEST(GraphSolver, WhatAScanCannotSeeIsPinnedOrFree) {
  const PoseGraphConfig config;
  GraphEdge e = edge(EdgeKind::kLidar, 1, 2, SE3::Identity());
  e.covariance(0, 2) = e.covariance(2, 0) = 1e-4;
  EXPECT_LT(effective_covariance(config.noise, e, true)(2, 2), 1e-4);
  EXPECT_GT(effective_covariance(config.noise, e, false)(2, 2), 0.9);
  EXPECT_EQ(effective_covariance(config.noise, e, true)(0, 2), 0.0);
  e.kind = EdgeKind::kVisual;
  EXPECT_DOUBLE_EQ(effective_covariance(config.noise, e, true)(0, 2),
                   1e-4 * config.noise.visual_optimism);
}

// Everything seen from everywhere: each node has an edge to each third other.
TEST(SparseProblem, ConjugateGradientsFindWhatCholeskyFinds) {
  Truth truth = square(8, 0.02, 0.01, 5);
  const auto n = static_cast<std::int64_t>(truth.poses.size());
  for (std::int64_t a = 1; a <= n; ++a)
    for (std::int64_t b = a + 2; b <= n; b += 3)
      truth.edges.push_back(edge(a % 2 == 0 ? EdgeKind::kLoop : EdgeKind::kVisual, a, b,
                                 truth.poses[a - 1].inverse() * truth.poses[b - 1]));
  SolveOptions options;
  options.anchor = keyframe(1);
  const PoseGraphConfig config;
  std::vector<GraphNodes> nodes;
  std::vector<double> costs;
  for (const double most_work : {1e12, 0.0}) {
    SparseProblem problem(config, options, truth.nodes, truth.edges);
    problem.set_most_work(most_work);
    Poses poses = problem.start();
    int iterations = 0;
    bool usable = true;
    costs.push_back(problem.minimise(1.0, 30, &poses, &iterations, &usable));
    EXPECT_TRUE(usable);
    nodes.push_back(truth.nodes);
    problem.write_back(poses, &nodes.back());
  }
  EXPECT_NEAR(costs[1], costs[0], 1e-6 * costs[0]);
  for (const auto& [id, node] : nodes[0])
    EXPECT_LT((node.T_map_base.inverse() * nodes[1].at(id).T_map_base).translation().norm(), 1e-5);
}

}  // namespace
}  // namespace fusion_slam
