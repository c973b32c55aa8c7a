// What the pose graph writes down of itself, and how it goes on from there.
#include <cstdint>
#include <future>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/services/pose_graph/rounds.hpp"

namespace fusion_slam {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes written(const PoseGraph& graph) {
  Bytes bytes;
  NoteWriter out(&bytes);
  graph.write(&out);
  return bytes;
}

bool restore(const Bytes& bytes, PoseGraph* graph) {
  NoteReader in(bytes.data(), bytes.size());
  return graph->restore(&in);
}

constexpr int kState = 11 * Rounds::kPerRound + 5;  // nodes that came before it
constexpr int kNodes = 14 * Rounds::kPerRound;

// With something of everything that waits.
void let_wait(PoseGraph* graph) {
  NodeInput orphan;
  orphan.id = node(5000);
  orphan.utime_us = graph->newest_utime_us();
  orphan.previous_id = 4999;
  orphan.refined = {{4998, from_xyz_rpy(0.1, 0, 0, 0, 0, 0)}};
  orphan.seen = {{7, 3, 10.5F, 20.5F, 2.0F, 0.1F, 1}};
  graph->add_node(orphan);
  graph->add_loop({node(1), node(5000), SE3::Identity(), Matrix6d::Identity(), {{1, 2}}});
  graph->add_odometry(graph->newest_utime_us(), from_xyz_rpy(1, 2, 3, 0, 0, 0));
}

// But for the last bits: of a covariance one triangle is written.
TEST(SavedState, GoesOnAsIfNothingHadBeen) {
  const Rounds rounds(kNodes);
  PoseGraphConfig config;
  config.loop_chi2 = 1e9;  // what is being solved elsewhere is not in it
  PoseGraph graph = camera_graph(true, config), again = camera_graph(true, config);
  rounds.feed(&graph, 0, kState);
  let_wait(&graph);
  ASSERT_GT(graph.counts().retired, 50);
  graph.take_changes();
  graph.take_poses();
  graph.take_retirements();
  const Bytes state = written(graph);
  ASSERT_TRUE(restore(state, &again));
  EXPECT_EQ(written(again), state);
  EXPECT_EQ(again.counts().loops, graph.counts().loops);
  EXPECT_TRUE(again.take_changes().empty()) << "all has been said";
  for (PoseGraph* each : {&graph, &again}) {
    rounds.feed(each, kState, kNodes);
    each->finish();
  }
  const auto poses = all_poses(graph), poses_again = all_poses(again);
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(kNodes + 1));
  ASSERT_EQ(poses_again.size(), poses.size());
  for (const auto& [id, T] : poses) EXPECT_TRUE(poses_again.at(id).isApprox(T, 1e-9)) << id.id;
  const auto said = graph.take_poses(), said_again = again.take_poses();
  ASSERT_EQ(said_again.size(), said.size());
  for (std::size_t i = 0; i < said.size(); ++i)
    EXPECT_TRUE(said_again[i].T_map_base.isApprox(said[i].T_map_base, 1e-9)) << i;
}

TEST(SavedState, WhatBecameOfItSinceIsKnown) {
  const Rounds rounds(kNodes);
  PoseGraph graph = camera_graph(true), again = camera_graph(true);
  rounds.feed(&graph, 0, kState);
  graph.take_changes();
  graph.take_retirements();
  ASSERT_TRUE(restore(written(graph), &again));
  PoseGraph::Earlier since;
  for (int i = kState; i < kNodes; ++i) {
    rounds.feed(&graph, i, i + 1);
    for (const auto& [id, at] : graph.take_changes()) since.T_map_base[id] = at.T_map_base;
    for (const auto& [n, r] : graph.take_retirements()) since.retired[n].push_back(r);
  }
  ASSERT_GT(since.retired.size(), 1U);
  again.rebuild(since);
  rounds.feed(&again, kState, kNodes);
  again.rebuilt();
  EXPECT_EQ(again.counts().retired, graph.counts().retired);
  EXPECT_EQ(again.edges().size(), graph.edges().size());
  const auto poses = all_poses(graph), poses_again = all_poses(again);
  ASSERT_EQ(poses.size(), poses_again.size());
  for (const auto& [id, T] : poses) EXPECT_LT(local(T, poses_again.at(id)).norm(), 0.004) << id.id;
}

TEST(SavedState, ALoopThatWasSwitchedOffSinceIsOff) {
  const Rounds rounds(kState);
  PoseGraph graph = camera_graph(false), again = camera_graph(false);
  rounds.feed(&graph, 0, 3 * Rounds::kPerRound);
  ASSERT_TRUE(restore(written(graph), &again));
  const NodeId from = node(1), to = node(2 * Rounds::kPerRound + 1);
  const auto loops = [&] {
    int n = 0;
    for (const GraphEdge& edge : again.edges())
      n += edge.kind == EdgeKind::kLoop && edge.from == from && edge.to == to;
    return n;
  };
  ASSERT_GT(loops(), 0);
  PoseGraph::Earlier since;
  since.switched_off.push_back({from, to, 99.0, "it did not fit"});
  again.rebuild(since);
  again.rebuilt();
  EXPECT_EQ(loops(), 0);
  ASSERT_EQ(again.switched_off().size(), 1U);
  EXPECT_EQ(again.switched_off()[0].reason, "it did not fit");

  PoseGraph third = camera_graph(false);  // off in the state already, and said again since
  ASSERT_TRUE(restore(written(again), &third));
  third.rebuild(since);
  third.rebuilt();
  EXPECT_EQ(third.switched_off().size(), 1U);
  EXPECT_EQ(third.counts().loops_switched_off, 1);
}

// Live, a large graph that was built up again can't know how long a solve takes.
TEST(SavedState, ItsFirstSolveIsMadeElsewhere) {
  const Rounds rounds(kState);
  constexpr int kBefore = 10 * Rounds::kPerRound;
  PoseGraph graph = camera_graph(false);
  rounds.feed(&graph, 0, kBefore);
  std::promise<void> go;
  PoseGraphConfig config;
  config.quiet_chi2 = 0.0;  // every loop pulls
  config.loop_chi2 = 1e9;   // and none asks for more than a quick solve
  config.wait_for_solver = false;
  config.solver_begins = [gone = go.get_future().share()] { gone.wait(); };
  PoseGraph again = camera_graph(false, config);
  ASSERT_TRUE(restore(written(graph), &again));
  const std::int64_t solves = again.counts().solves;
  rounds.feed(&again, kBefore, kState - 1);
  EXPECT_EQ(again.counts().solves, solves) << "nobody let it begin";
  EXPECT_EQ(again.n_nodes(), static_cast<std::size_t>(kState - 1));
  go.set_value();
  while (again.counts().solves == solves) {
    std::this_thread::yield();
    PoseInput lost;
    lost.state = PoseState::kLost;
    lost.utime_us = again.newest_utime_us();
    again.add_pose(lost);
  }
}

TEST(SavedState, HalfOfItIsNothing) {
  const Rounds rounds(kState);
  PoseGraph graph = camera_graph(true);
  rounds.feed(&graph, 0, kState);
  let_wait(&graph);
  const Bytes state = written(graph);
  PoseGraph again = camera_graph(true);
  for (std::size_t size = 0; size < state.size(); size += 1 + size / 64) {
    ASSERT_FALSE(
        restore(Bytes(state.begin(), state.begin() + static_cast<std::ptrdiff_t>(size)), &again))
        << size;
    ASSERT_EQ(again.n_nodes(), 0U);
  }
  Bytes longer = state;
  longer.push_back(0);
  EXPECT_FALSE(restore(longer, &again));
  Bytes other_version = state;
  other_version[0] ^= 0x40;
  EXPECT_FALSE(restore(other_version, &again));
  rounds.feed(&again, 0, 30);
  EXPECT_EQ(again.n_nodes(), 30U);
}

}  // namespace
}  // namespace fusion_slam
