#include "services/loop_detector/consistency.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

NodeId node(std::int64_t id) { return {NodeKind::kKeyframe, id}; }

Matrix6d sure(double sigma) { return Matrix6d::Identity() * sigma * sigma; }

// Thirty keyframes on a straight line, 0.5 m apart, as a tracker saw them.
GraphKnowledge line() {
  GraphKnowledge graph;
  for (std::int64_t id = 1; id <= 30; ++id) {
    LoopKeyframe keyframe;
    keyframe.id = id;
    keyframe.utime_us = id * 1'000'000;
    keyframe.previous_id = id - 1;
    keyframe.T_previous_base = from_xyz_rpy(0.5, 0, 0, 0, 0, 0);
    keyframe.covariance = sure(0.002);
    keyframe.T_odom_base = from_xyz_rpy(0.5 * static_cast<double>(id), 0, 0, 0, 0, 0);
    graph.add(keyframe);
    graph.moved(node(id), keyframe.T_odom_base);
  }
  return graph;
}

// A loop that says the truth, but for `off_m` to the side.
LoopCandidate loop(std::int64_t from, std::int64_t to, double off_m) {
  LoopCandidate candidate;
  candidate.from = node(from);
  candidate.to = node(to);
  candidate.utime_us = to * 1'000'000;
  LoopMeasurement m;
  m.from = candidate.from;
  m.to = candidate.to;
  m.T_from_to = from_xyz_rpy(0.5 * static_cast<double>(to - from), off_m, 0, 0, 0, 0);
  m.covariance = sure(0.01);
  candidate.measurements.push_back(m);
  candidate.stages.push_back({"consistency", 0.0, 0.0, true, "inside"});
  return candidate;
}

TEST(Consistency, TheGateIsTheGraphsUncertainty) {
  const Consistency consistency{ConsistencyConfig{}};
  const GraphKnowledge graph = line();
  const auto near = consistency.gate(graph, loop(1, 28, 0.05).measurements[0]);
  EXPECT_TRUE(near.inside) << near.reason;
  const auto far = consistency.gate(graph, loop(1, 28, 3.0).measurements[0]);
  EXPECT_FALSE(far.inside);
  EXPECT_NE(far.reason.find("more than it can be wrong"), std::string::npos);
  // After a longer way it may be wrong by more.
  EXPECT_GT(near.sigma_m, consistency.gate(graph, loop(1, 5, 0.0).measurements[0]).sigma_m);
  EXPECT_FALSE(consistency.gate(graph, loop(1, 99, 0.0).measurements[0]).inside);  // unknown node
}

TEST(Consistency, ALoopWaitsForAnotherFromAnotherPlace) {
  Consistency consistency{ConsistencyConfig{}};
  const GraphKnowledge graph = line();
  EXPECT_TRUE(consistency.judge(graph, loop(1, 25, 0.0), 2).empty());
  const auto decided = consistency.judge(graph, loop(2, 27, 0.005), 2);
  ASSERT_EQ(decided.size(), 2U);  // the one that waited is vouched for, too
  for (const LoopCandidate& candidate : decided) {
    EXPECT_TRUE(candidate.accepted);
    EXPECT_EQ(candidate.stages.back().score, 2.0);
  }
}

TEST(Consistency, OnesThatContradictEachOtherWaitUntilTheirTimeIsOver) {
  ConsistencyConfig config;
  Consistency consistency{config};
  const GraphKnowledge graph = line();
  EXPECT_TRUE(consistency.judge(graph, loop(1, 25, 0.3), 2).empty());
  EXPECT_TRUE(consistency.judge(graph, loop(2, 27, -0.3), 2).empty());
  EXPECT_TRUE(consistency.expired(30'000'000, false).empty());
  const auto decided = consistency.expired(25'000'000 + config.wait_us, false);
  ASSERT_EQ(decided.size(), 1U);
  EXPECT_FALSE(decided[0].accepted);
  EXPECT_EQ(consistency.expired(0, true).size(), 1U);
}

TEST(Consistency, TwoViewsFromOnePlaceAreOneWitness) {
  Consistency consistency{ConsistencyConfig{}};
  const GraphKnowledge graph = line();
  EXPECT_TRUE(consistency.judge(graph, loop(1, 25, 0.0), 2).empty());
  EXPECT_TRUE(consistency.judge(graph, loop(2, 25, 0.0), 2).empty());
}

TEST(Consistency, WhatWasSwitchedOffVouchesForNothing) {
  Consistency consistency{ConsistencyConfig{}};
  const GraphKnowledge graph = line();
  ASSERT_EQ(consistency.judge(graph, loop(1, 25, 0.0), 1).size(), 1U);
  consistency.forget(node(1), node(25));
  EXPECT_TRUE(consistency.judge(graph, loop(2, 27, 0.0), 2).empty());
}

// x, y and yaw only for planar robots: the slow way by hand.
TEST(Consistency, SquaredDistance) {
  Vector6d e;
  e << 0.1, 0.2, 5.0, 1.0, 1.0, 0.3;
  Matrix6d c = Matrix6d::Identity();
  c.diagonal() << 0.01, 0.04, 1, 1, 1, 0.09;
  EXPECT_NEAR(squared_distance(e, c, true), 3.0, 1e-9);
  EXPECT_NEAR(squared_distance(e, c, false), 3.0 + 27.0, 1e-9);
}

}  // namespace
}  // namespace fusion_slam
