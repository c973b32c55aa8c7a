#include "libs/graph/uncertainty.hpp"

#include <random>

#include <gtest/gtest.h>

#include "libs/graph/edge_noise.hpp"

namespace fusion_slam {
namespace {

NodeId node(std::int64_t id) { return {NodeKind::kLidar, id}; }

Matrix6d small(double sigma_m, double sigma_rad) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(sigma_m * sigma_m),
      Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return d.asDiagonal();
}

Vector6d noise(std::mt19937* random, double sigma_m, double sigma_rad) {
  std::normal_distribution<double> gauss;
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = gauss(*random) * (i < 3 ? sigma_m : sigma_rad);
  return xi;
}

// Many noisy chains: their ends scatter as the sum along the path says. One edge is told backwards.
TEST(GraphUncertainty, AgreesWithScatterOfManyChains) {
  const std::vector<SE3> steps{from_xyz_rpy(2.0, 0.3, 0, 0, 0, 0.6),
                               from_xyz_rpy(1.5, -0.4, 0.2, 0.1, 0, -1.0),
                               from_xyz_rpy(3.0, 0, 0, 0, 0.2, 0.3)};
  const double sigma_m = 0.01, sigma_rad = 0.004;
  GraphUncertainty graph;
  graph.add_edge(node(1), node(2), steps[0], small(sigma_m, sigma_rad));
  graph.add_edge(node(3), node(2), steps[1].inverse(),
                 inverse_covariance(small(sigma_m, sigma_rad), steps[1]));
  graph.add_edge(node(3), node(4), steps[2], small(sigma_m, sigma_rad));
  const auto there = graph.from(node(1)).to(node(4));
  ASSERT_TRUE(there);
  const SE3 expected = steps[0] * steps[1] * steps[2];
  EXPECT_TRUE(there->T_start_node.isApprox(expected, 1e-9));

  std::mt19937 random(1);
  Matrix6d scatter = Matrix6d::Zero();
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    SE3 end = SE3::Identity();
    for (const SE3& step : steps) end = end * retract(step, noise(&random, sigma_m, sigma_rad));
    const Vector6d xi = local(expected, end);
    scatter += xi * xi.transpose() / n;
  }
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(std::sqrt(there->covariance(i, i) / scatter(i, i)), 1.0, 0.03) << i;
}

// Dijkstra against trying every path of a small graph.
TEST(GraphUncertainty, TakesTheBestPath) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    GraphUncertainty graph;
    const int n = 6;
    std::vector<std::vector<double>> cost(n, std::vector<double>(n, 1e9));
    for (int a = 0; a < n; ++a)
      for (int b = a + 1; b < n; ++b) {
        if (random() % 3 == 0) continue;
        const double variance = 1e-4 * (1 + random() % 100);
        graph.add_edge(node(a + 1), node(b + 1), SE3::Identity(),
                       Matrix6d(Matrix6d::Identity() * variance));
        cost[a][b] = cost[b][a] = variance;
      }
    std::vector<std::vector<double>> best = cost;
    for (int i = 0; i < n; ++i) best[i][i] = 0.0;
    for (int k = 0; k < n; ++k)
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) best[a][b] = std::min(best[a][b], best[a][k] + best[k][b]);
    auto paths = graph.from(node(1));
    for (int b = 1; b < n; ++b) {
      const auto found = paths.to(node(b + 1));
      ASSERT_EQ(found.has_value(), best[0][b] < 1e8);
      if (found) {
        EXPECT_NEAR(found->covariance(0, 0), best[0][b], 1e-12);
      }
    }
  }
}

TEST(GraphUncertainty, ALoopThatIsGoneIsNoPath) {
  GraphUncertainty graph;
  graph.add_edge(node(1), node(2), from_xyz_rpy(1, 0, 0, 0, 0, 0), small(0.5, 0.5));
  graph.add_edge(node(1), node(2), from_xyz_rpy(1, 0, 0, 0, 0, 0), small(0.01, 0.01), true);
  EXPECT_LT(graph.from(node(1)).to(node(2))->covariance(0, 0), 0.01);
  graph.remove_loops(node(1), node(2));
  EXPECT_GT(graph.from(node(1)).to(node(2))->covariance(0, 0), 0.2);
  EXPECT_FALSE(graph.from(node(1)).to(node(9)));
  EXPECT_FALSE(graph.from(node(9)).to(node(1)));
}

// Between the nodes that are left every best path says what it said before.
TEST(GraphUncertainty, WhoIsRetiredLeavesThePathsBetweenTheOthers) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::mt19937 random(seed);
    const auto share = [&] { return static_cast<double>(random() % 1000) / 1000.0; };
    GraphUncertainty graph;
    const int n = 25;
    for (int a = 1; a <= n; ++a)
      for (int b = a + 1; b <= n; ++b) {
        if (b != a + 1 && random() % 8 != 0) continue;
        graph.add_edge(node(a), node(b), from_xyz_rpy(share(), share(), 0, 0, 0, share()),
                       small(0.01 + 0.05 * share(), 0.001 + 0.01 * share()), random() % 2 == 0);
      }
    const GraphUncertainty whole = graph;
    for (int gone = 2; gone <= n; gone += 1 + static_cast<int>(random() % 3)) {
      graph.retire(node(gone));
      EXPECT_FALSE(graph.from(node(1)).to(node(gone)));
    }
    EXPECT_LT(graph.n_nodes(), whole.n_nodes());
    for (int a = 1; a <= n; ++a)
      for (int b = 1; b <= n; ++b) {
        const auto is = graph.from(node(a)).to(node(b));
        if (!is) continue;
        const auto was = whole.from(node(a)).to(node(b));
        ASSERT_TRUE(was);
        EXPECT_TRUE(is->covariance.isApprox(was->covariance, 1e-9)) << a << " " << b;
        EXPECT_TRUE(is->T_start_node.isApprox(was->T_start_node, 1e-9));
      }
    EXPECT_TRUE(graph.from(node(1)).to(node(1)));
  }
}

// A robot that goes around the same five places for ever.
TEST(GraphUncertainty, RoundsThatAreRetiredLeaveNothingBehind) {
  GraphUncertainty graph;
  for (int id = 2; id <= 2000; ++id) {
    graph.add_edge(node(id - 1), node(id), SE3::Identity(), small(0.01, 0.001));
    if (id > 5)
      graph.add_edge(node(1 + id % 5), node(id), SE3::Identity(), small(0.01, 0.002), true);
    if (id > 25) graph.retire(node(id - 20));
  }
  EXPECT_LT(graph.n_nodes(), 30U);
  EXPECT_LT(graph.n_edges(), 100U);
}

// With holes where nodes and edges were, and all three sorts of edges.
TEST(GraphUncertainty, WrittenDownAndReadBackItSaysTheSame) {
  std::mt19937 random(3);
  GraphUncertainty graph;
  for (int id = 2; id <= 60; ++id) {
    graph.add_edge(node(id - 1), node(id), from_xyz_rpy(0.1 * id, 0, 0.2, 0, 0.1, 0.3),
                   small(0.01, 0.001));
    const NodeId other = node(1 + static_cast<int>(random() % id));
    graph.add_edge(other, node(id), from_xyz_rpy(1, 2, 0, 0, 0, 1), small(0.02, 0.002), true);
    if (id % 3 == 0) graph.retire(node(id - 1));
    if (id % 10 == 0) graph.remove_loops(other, node(id));
  }
  std::vector<std::uint8_t> bytes;
  NoteWriter out(&bytes);
  graph.write(&out);
  GraphUncertainty back;
  NoteReader in(bytes.data(), bytes.size());
  ASSERT_TRUE(back.read(&in));
  EXPECT_FALSE(in.more());
  EXPECT_EQ(back.n_nodes(), graph.n_nodes());
  EXPECT_EQ(back.n_edges(), graph.n_edges());
  std::size_t reached = 0;
  const auto compare = [&] {
    for (int a = 1; a <= 60; ++a)
      for (int b = 1; b <= 60; ++b) {
        const auto was = graph.from(node(a)).to(node(b));
        const auto is = back.from(node(a)).to(node(b));
        ASSERT_EQ(is.has_value(), was.has_value());
        if (!is) continue;
        ++reached;
        EXPECT_TRUE(is->covariance.isApprox(was->covariance, 1e-9)) << a << " " << b;
      }
  };
  compare();
  for (int id = 1; id <= 60; id += 7)
    for (GraphUncertainty* g : {&graph, &back}) g->retire(node(id));
  compare();
  EXPECT_GT(reached, 1000U);
}

TEST(GraphUncertainty, DamagedBytesAreRefused) {
  GraphUncertainty graph;
  graph.add_edge(node(1), node(2), SE3::Identity(), small(0.01, 0.001));
  std::vector<std::uint8_t> bytes;
  NoteWriter out(&bytes);
  graph.write(&out);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    GraphUncertainty back;
    NoteReader in(bytes.data(), n);
    EXPECT_FALSE(back.read(&in)) << n;
    EXPECT_EQ(back.n_nodes(), 0U);
  }
  bytes[4 + 2 * 9 + 4] = 7;  // the edge's first end: no such node
  NoteReader in(bytes.data(), bytes.size());
  EXPECT_FALSE(GraphUncertainty().read(&in));
}

TEST(GraphUncertainty, NonsenseIsIgnored) {
  GraphUncertainty graph;
  graph.add_edge(node(1), node(1), SE3::Identity(), small(1, 1));
  Matrix6d bad = small(1, 1);
  bad(0, 0) = std::numeric_limits<double>::quiet_NaN();
  graph.add_edge(node(1), node(2), SE3::Identity(), bad);
  EXPECT_EQ(graph.n_edges(), 0U);
}

TEST(EdgeNoise, WhatAScanCannotSeeIsPinnedOrFree) {
  const EdgeNoiseConfig config;
  GraphEdge e{EdgeKind::kLidar, node(1), node(2), SE3::Identity(), small(0.01, 0.01), 1.0};
  e.covariance(0, 2) = e.covariance(2, 0) = 1e-5;
  EXPECT_LT(effective_covariance(config, e, true)(2, 2), 1e-4);
  EXPECT_GT(effective_covariance(config, e, false)(2, 2), 0.9);
  EXPECT_EQ(effective_covariance(config, e, true)(0, 2), 0.0);
}

}  // namespace
}  // namespace fusion_slam
