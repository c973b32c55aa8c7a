// Global bundle adjustment as a part of the pose graph: when it is asked for, where it is met.
#include <atomic>
#include <chrono>
#include <future>
#include <thread>

#include <gtest/gtest.h>

#include "services/pose_graph/pose_graph.hpp"
#include "tests/services/pose_graph/made_up_room.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kPeriodUs = 500'000;

RobotModel robot(const MadeUpRoom& room, bool planar) {
  RobotModel robot;
  robot.has_camera = true;
  robot.planar = planar;
  robot.T_base_camera = room.question.T_base_camera;
  return robot;
}

// The store of a made-up room gives no features away: what was seen is told again by a tracker that
// names each point anew after `new_names_from`, so that only the loop knows they are the same.
struct Drive {
  MadeUpRoom room;
  std::size_t new_names_from;

  NodeInput keyframe(std::size_t k) const {
    NodeInput node;
    node.id = MadeUpRoom::id(k);
    node.utime_us = static_cast<std::int64_t>(k + 1) * kPeriodUs;
    node.seen = room.seen[k];
    if (k >= new_names_from)
      for (SeenFeature& f : node.seen) f.landmark += 100'000;
    if (k > 0) {
      node.previous_id = static_cast<std::int64_t>(k);
      node.T_previous_base = room.edges[k - 1].T_from_to;
      node.covariance = room.edges[k - 1].covariance;
    }
    return node;
  }
  // By the points that both see.
  LoopInput loop(std::size_t from, std::size_t to) const {
    LoopInput loop;
    loop.from = MadeUpRoom::id(from);
    loop.to = MadeUpRoom::id(to);
    loop.T_from_to = room.truth[from].inverse() * room.truth[to];
    loop.covariance = Matrix6d::Identity() * 1e-4;
    for (const SeenFeature& a : room.seen[from])
      for (const SeenFeature& b : room.seen[to])
        if (a.landmark == b.landmark) loop.same_features.emplace_back(a.index, b.index);
    return loop;
  }
};

constexpr std::size_t kKeyframes = 40;

TEST(BundleInGraph, ALoopOfTheCameraBringsItAndTheRestFollows) {
  const Drive drive{MadeUpRoom(kKeyframes, 500, 0.01, 0.004, 1), 30};
  PoseGraph graph;
  graph.set_robot(robot(drive.room, true));
  graph.set_camera(drive.room.question.camera);
  for (std::size_t k = 0; k < kKeyframes; ++k) graph.add_node(drive.keyframe(k));
  EXPECT_EQ(graph.counts().bundles, 0);  // nothing has closed
  graph.add_loop(drive.loop(1, 37));
  graph.finish();
  EXPECT_GE(graph.counts().bundles, 1) << graph.last_bundle().reason;
  EXPECT_EQ(graph.counts().bundles_refused, 0);
  EXPECT_LT(drive.room.worst_m(graph.nodes()), 0.06);
}

// However long it takes: poses and nodes go on, and the answer is taken over when it is there.
TEST(BundleInGraph, OnARobotNothingWaitsForIt) {
  const Drive drive{MadeUpRoom(kKeyframes, 500, 0.01, 0.004, 1), 30};
  std::promise<void> go;
  PoseGraphConfig config;
  config.wait_for_solver = false;
  config.solver_begins = [gone = go.get_future().share()] { gone.wait(); };
  PoseGraph graph(config);
  graph.set_robot(robot(drive.room, true));
  graph.set_camera(drive.room.question.camera);
  for (std::size_t k = 0; k < 38; ++k) graph.add_node(drive.keyframe(k));
  graph.add_loop(drive.loop(1, 37));
  for (std::size_t k = 38; k < kKeyframes; ++k) {
    NodeInput late = drive.keyframe(k);
    late.utime_us += 60'000'000;  // far beyond the meeting point
    graph.add_node(late);
  }
  EXPECT_EQ(graph.nodes().size(), kKeyframes);
  EXPECT_EQ(graph.counts().bundles + graph.counts().bundles_refused, 0) << "nobody let it begin";
  go.set_value();
  graph.finish();
  EXPECT_GE(graph.counts().bundles, 1) << graph.last_bundle().reason;
  EXPECT_LT(drive.room.worst_m(graph.nodes()), 0.06);
}

// Loops that don't fit keep coming: on a robot the solver has its share of a core and no more.
TEST(BundleInGraph, OnARobotTheSolverRests) {
  const Drive drive{MadeUpRoom(kKeyframes, 300, 0.01, 0.004, 1), 30};
  std::atomic<int> n_solves{0};
  PoseGraphConfig config;
  config.wait_for_solver = false;
  config.meet_after_us = 0;
  config.solver_share = 1e-9;  // once, and then never again
  config.solver_begins = [&] { ++n_solves; };
  PoseGraph graph(config);
  graph.set_robot(robot(drive.room, true));
  for (std::size_t k = 0; k < 30; ++k) graph.add_node(drive.keyframe(k));
  const auto contradict = [&](std::size_t from, std::size_t to) {
    LoopInput wrong = drive.loop(from, to);
    wrong.T_from_to = wrong.T_from_to * from_xyz_rpy(3.0, 0, 0, 0, 0, 0);
    graph.add_loop(wrong);
  };
  contradict(1, 25);
  while (n_solves == 0) std::this_thread::yield();
  for (std::size_t k = 30; k < kKeyframes; ++k) {
    // Slow or fast: the answer is there before the next node asks for it.
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    graph.add_node(drive.keyframe(k));
    contradict(k - 28, k - 1);
  }
  EXPECT_EQ(n_solves, 1);
  graph.finish();
  EXPECT_GT(n_solves, 1);
}

// Loops that pull keep coming: the thread that says the poses has more to do than to solve. What
// waits is solved when it has rested.
TEST(BundleInGraph, OnARobotSolvesBetweenMessagesRestToo) {
  const Drive drive{MadeUpRoom(kKeyframes, 300, 0.01, 0.004, 1), 30};
  const auto solves = [&](bool wait_for_solver, double share, std::int64_t then_us) {
    PoseGraphConfig config;
    config.wait_for_solver = wait_for_solver;
    config.quick_share = share;
    config.longest_quick_us = 3'600'000'000;
    config.quiet_chi2 = 0.0;  // every loop pulls
    config.loop_chi2 = 1e9;   // and none asks for more than a quick solve
    PoseGraph graph(config);
    graph.set_robot(robot(drive.room, true));
    for (std::size_t k = 0; k < 30; ++k) graph.add_node(drive.keyframe(k));
    for (std::size_t k = 1; k < 8; ++k) graph.add_loop(drive.loop(k, k + 20));
    NodeInput late = drive.keyframe(30);
    late.utime_us += then_us;
    graph.add_node(late);
    return graph.counts().solves;
  };
  EXPECT_EQ(solves(true, 1e-9, 0), 7) << "a replay waits for nothing";
  EXPECT_EQ(solves(false, 1.0, 0), 7) << "nothing to rest from";
  EXPECT_EQ(solves(false, 1e-7, 0), 1);
  EXPECT_EQ(solves(false, 1e-3, 3'600'000'000), 2) << "an hour later what waited is solved";
}

// And where one takes long, in a thread of its own: nodes go on meanwhile, and come out where they
// would have.
TEST(BundleInGraph, OnARobotALongSolveBetweenMessagesIsMadeElsewhere) {
  const Drive drive{MadeUpRoom(kKeyframes, 300, 0.01, 0.004, 1), 30};
  std::promise<void> go;
  PoseGraphConfig config;
  config.quiet_chi2 = 0.0;  // every loop pulls
  config.loop_chi2 = 1e9;   // and none asks for more than a quick solve
  PoseGraph expected(config);
  config.wait_for_solver = false;
  config.longest_quick_us = -1;
  config.solver_begins = [gone = go.get_future().share()] { gone.wait(); };
  PoseGraph graph(config);
  for (PoseGraph* each : {&expected, &graph}) {
    each->set_robot(robot(drive.room, true));
    for (std::size_t k = 0; k < 30; ++k) each->add_node(drive.keyframe(k));
    each->add_loop(drive.loop(1, 21));
    for (std::size_t k = 30; k < 35; ++k) each->add_node(drive.keyframe(k));
  }
  EXPECT_EQ(graph.nodes().size(), 35u);
  EXPECT_EQ(graph.counts().solves, 0) << "nobody let it begin";
  go.set_value();
  PoseInput lost;
  lost.state = PoseState::kLost;
  lost.utime_us = graph.newest_utime_us();
  while (graph.counts().solves == 0) {
    std::this_thread::yield();
    graph.add_pose(lost);
  }
  for (const auto& [id, node] : expected.nodes())
    EXPECT_TRUE(graph.nodes().at(id).T_map_base.isApprox(node.T_map_base, 1e-9)) << id.id;
  for (PoseGraph* each : {&expected, &graph}) {
    each->add_loop(drive.loop(2, 22));
    for (std::size_t k = 35; k < kKeyframes; ++k) each->add_node(drive.keyframe(k));
    each->finish();  // one of them while it solves elsewhere
  }
  for (const auto& [id, node] : expected.nodes())
    EXPECT_TRUE(graph.nodes().at(id).T_map_base.isApprox(node.T_map_base, 1e-6)) << id.id;
}

// The journal's state has what was seen, and the pairs of features.
TEST(BundleInGraph, RestoredItIsTheSame) {
  const Drive drive{MadeUpRoom(kKeyframes, 300, 0.01, 0.004, 1), 30};
  PoseGraphConfig config;
  config.quiet_chi2 = config.loop_chi2 = 1e9;  // the loop waits for company
  PoseGraph graph(config), again(config);
  for (PoseGraph* each : {&graph, &again}) each->set_robot(robot(drive.room, true));
  for (std::size_t k = 0; k < 35; ++k) graph.add_node(drive.keyframe(k));
  graph.add_loop(drive.loop(1, 33));
  std::vector<std::uint8_t> bytes;
  NoteWriter out(&bytes);
  graph.write(&out);
  NoteReader in(bytes.data(), bytes.size());
  ASSERT_TRUE(again.restore(&in));
  for (PoseGraph* each : {&graph, &again}) {
    each->set_camera(drive.room.question.camera);
    for (std::size_t k = 35; k < kKeyframes; ++k) each->add_node(drive.keyframe(k));
    each->finish();
    EXPECT_GE(each->counts().bundles, 1) << each->last_bundle().reason;
  }
  for (const auto& [id, node] : graph.nodes())
    EXPECT_EQ(again.nodes().at(id).T_map_base.matrix(), node.T_map_base.matrix()) << id.id;
}

TEST(BundleInGraph, NoCameraModelNoBundle) {
  const Drive drive{MadeUpRoom(kKeyframes, 500, 0.01, 0.004, 1), 30};
  PoseGraph graph;
  graph.set_robot(robot(drive.room, true));
  for (std::size_t k = 0; k < kKeyframes; ++k) graph.add_node(drive.keyframe(k));
  graph.add_loop(drive.loop(1, 37));
  graph.finish();
  EXPECT_EQ(graph.counts().bundles + graph.counts().bundles_refused, 0);
}

// It is met at a measurement time, however fast its thread was: two runs, the same bits.
TEST(BundleInGraph, TheSameBitsTwice) {
  const Drive drive{MadeUpRoom(kKeyframes, 300, 0.01, 0.004, 2), 30};
  GraphNodes nodes[2];
  for (GraphNodes& result : nodes) {
    PoseGraph graph;
    graph.set_robot(robot(drive.room, true));
    graph.set_camera(drive.room.question.camera);
    for (std::size_t k = 0; k < kKeyframes; ++k) {
      graph.add_node(drive.keyframe(k));
      if (k == 36) graph.add_loop(drive.loop(0, 36));
      if (k == 39) graph.add_loop(drive.loop(2, 38));
    }
    result = graph.nodes();
    graph.finish();
  }
  for (const auto& [id, node] : nodes[0])
    EXPECT_EQ(node.T_map_base.matrix(), nodes[1].at(id).T_map_base.matrix());
}

// The map is levelled while the thread still works on the map as it was.
TEST(BundleInGraph, LevelledMeanwhileTheMapStaysLevel) {
  const Drive drive{MadeUpRoom(kKeyframes, 300, 0.01, 0.004, 3), 30};
  PoseGraph graph;
  graph.set_robot(robot(drive.room, false));
  graph.set_camera(drive.room.question.camera);
  for (std::size_t k = 0; k < kKeyframes; ++k) graph.add_node(drive.keyframe(k));
  graph.add_loop(drive.loop(1, 37));  // asks for it
  std::string why;
  ASSERT_TRUE(graph.level_map(MadeUpRoom::id(0), from_xyz_rpy(0, 0, 1.3, 0.4, 0, 0), &why)) << why;
  graph.finish();
  EXPECT_GE(graph.counts().bundles, 1) << graph.last_bundle().reason;
  const SE3& first = graph.nodes().at(MadeUpRoom::id(0)).T_map_base;
  EXPECT_NEAR(first.translation().z(), 1.3, 1e-9);
  EXPECT_NEAR(first.linear()(2, 1), std::sin(0.4), 1e-9);
}

// A loop that comes while the thread works is not forgotten by what it answers.
TEST(BundleInGraph, LoopsSinceThenStillHold) {
  const Drive drive{MadeUpRoom(kKeyframes, 500, 0.01, 0.004, 4), 30};
  PoseGraph graph;
  graph.set_robot(robot(drive.room, true));
  graph.set_camera(drive.room.question.camera);
  for (std::size_t k = 0; k < 37; ++k) graph.add_node(drive.keyframe(k));
  graph.add_loop(drive.loop(0, 36));
  for (std::size_t k = 37; k < kKeyframes; ++k) {
    graph.add_node(drive.keyframe(k));
    graph.add_loop(drive.loop(k - 36, k));
  }
  NodeInput later = drive.keyframe(kKeyframes - 1);  // time goes on: the answer is taken over
  later.id.id += 1;
  later.utime_us += 20'000'000;
  later.previous_id = static_cast<std::int64_t>(kKeyframes);
  later.T_previous_base = SE3::Identity();
  later.seen.clear();
  graph.add_node(later);
  EXPECT_GE(graph.counts().bundles, 1) << graph.last_bundle().reason;
  for (const GraphEdge& edge : graph.edges())
    if (edge.kind == EdgeKind::kLoop) {
      EXPECT_LT(edge_error({}, true, graph.nodes(), edge), 16.8);
    }
}

}  // namespace
}  // namespace fusion_slam
