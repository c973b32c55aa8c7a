#include "logplayer/loops/loop_report.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "fusion_slam/graph_node_t.hpp"
#include "libs/messages/convert.hpp"
#include "logplayer/loops/read_session.hpp"

namespace fusion_slam {
namespace {

loop_candidate_t candidate(std::int64_t from, std::int64_t to, bool accepted) {
  loop_candidate_t m{};
  m.utime = to * 1'000'000;
  m.from_kind = m.to_kind = graph_node_t::LIDAR;
  m.from_id = from;
  m.to_id = to;
  m.accepted = accepted ? 1 : 0;
  for (const char* name : {"appearance", "geometry", "lidar", "consistency"}) {
    stage_verdict_t stage{};
    stage.stage = name;
    const bool lidar = stage.stage == "lidar" || stage.stage == "consistency";
    stage.passed = lidar && accepted ? 1 : 0;
    stage.reason = lidar ? "because" : "not asked: the LiDAR found it";
    m.stages.push_back(stage);
  }
  m.n_stages = 4;
  return m;
}

constraint_t constraint(std::int64_t from, std::int64_t to, const SE3& T) {
  constraint_t m{};
  m.from_kind = m.to_kind = graph_node_t::LIDAR;
  m.from_id = from;
  m.to_id = to;
  m.T_from_to = to_message(T, 0);
  m.source = "lidar loop";
  return m;
}

// A robot goes 40 m out and 40 m back on the same line, facing the same way, 1 m a second.
LoopReport there_and_back() {
  LoopReport report;
  for (std::int64_t s = 0; s <= 80; ++s) {
    for (int k = 0; k < 10; ++k) {
      const double x = s < 40 ? s + 0.1 * k : 80 - s - 0.1 * k;
      report.on_truth(s * 1'000'000 + k * 100'000, from_xyz_rpy(x, 0, 0, 0, 0, 0));
    }
    report.on_node({NodeKind::kLidar, s}, s * 1'000'000);
  }
  return report;
}

TEST(LoopReport, SaysWhatWasAcceptedAndWhyNot) {
  LoopReport report = there_and_back();
  report.on_candidate(candidate(10, 70, true));
  report.on_candidate(candidate(11, 69, false));
  report.on_constraint(constraint(10, 70, SE3::Identity()));
  graph_t graph{};
  graph.n_loops = 1;
  loop_state_t off{};
  off.from_kind = off.to_kind = graph_node_t::LIDAR;
  off.from_id = 10;
  off.to_id = 70;
  off.reason = "2 m off";
  graph.switched_off.push_back(off);
  report.on_graph(graph);
  const std::string brief = report.text({});
  EXPECT_NE(brief.find("scan 10 - scan 70"), std::string::npos) << brief;
  EXPECT_EQ(brief.find("scan 11 - scan 69"), std::string::npos) << brief;
  EXPECT_NE(brief.find("2 candidates, 1 accepted, 1 stopped at lidar"), std::string::npos) << brief;
  EXPECT_NE(brief.find("switched off: scan 10 - scan 70, 2 m off"), std::string::npos) << brief;
  LoopReportOptions all;
  all.all = true;
  EXPECT_NE(report.text(all).find("scan 11 - scan 69"), std::string::npos);
}

TEST(LoopReport, JudgesClosuresByTheTruth) {
  LoopReport report = there_and_back();
  report.on_constraint(constraint(10, 70, from_xyz_rpy(0.02, 0, 0, 0, 0, 0)));   // true: x = 10
  report.on_constraint(constraint(20, 61, from_xyz_rpy(-1.0, 0, 0, 0, 0, 0)));   // true: 19 - 20
  report.on_constraint(constraint(30, 70, from_xyz_rpy(-19.0, 0, 0, 0, 0, 0)));  // 1 m wrong
  const auto truth = report.judge({});
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->judged, 3U);
  EXPECT_EQ(truth->wrong, 1U);
  EXPECT_NEAR(truth->median_error_m, 0.02, 1e-6);
  // 30 s apart and within 1 m: from x = 25 or so on the way back.
  EXPECT_GE(truth->revisits, 24U);
  EXPECT_LE(truth->revisits, 27U);
  EXPECT_GE(truth->found, 8U);
  EXPECT_LE(truth->found, 11U);
  EXPECT_FALSE(LoopReport().judge({}));
}

TEST(LoopReport, NamesTheWrongOnesAndWhetherTheGraphFoundThemOut) {
  LoopReport report = there_and_back();
  report.on_constraint(constraint(20, 61, from_xyz_rpy(-1.0, 0, 0, 0, 0, 0)));
  report.on_constraint(constraint(30, 70, from_xyz_rpy(-19.0, 0, 0, 0, 0, 0)));
  EXPECT_NE(
      report.text({}).find("wrong: scan 30 - scan 70 (lidar loop), 1.00 m and 0.0 degrees beside "
                           "the truth\n"),
      std::string::npos)
      << report.text({});
  EXPECT_EQ(report.text({}).find("wrong: scan 20"), std::string::npos);
  graph_t graph{};
  loop_state_t off{};
  off.from_kind = off.to_kind = graph_node_t::LIDAR;
  off.from_id = 30;
  off.to_id = 70;
  graph.switched_off.push_back(off);
  report.on_graph(graph);
  EXPECT_NE(report.text({}).find("beside the truth; switched off again\n"), std::string::npos);
}

TEST(LoopReport, ANodeJustBeforeTheTruthBeginsIsJudged) {
  LoopReport report = there_and_back();
  report.on_node({NodeKind::kLidar, 100}, -200'000);
  report.on_node({NodeKind::kLidar, 101}, -300'000);
  report.on_constraint(constraint(100, 80, SE3::Identity()));
  report.on_constraint(constraint(101, 80, SE3::Identity()));
  EXPECT_EQ(report.judge({})->judged, 1U);
}

TEST(LoopReport, WritesClosuresAsRelations) {
  LoopReport report = there_and_back();
  report.on_constraint(constraint(10, 70, from_xyz_rpy(1.0, 0, 0, 0, 0, M_PI / 2)));
  report.on_constraint(constraint(10, 700, SE3::Identity()));  // no such node
  EXPECT_EQ(
      report.as_relations(),
      "10.000000 70.000000 1.000000 0.000000 0.000000 0.000000000 -0.000000000 1.570796327\n");
  report.on_robot(from_xyz_rpy(0.5, 0, 0, 0, 0, 0));  // a camera half a metre ahead of the base
  EXPECT_EQ(
      report.as_relations(),
      "10.000000 70.000000 0.500000 0.500000 0.000000 0.000000000 -0.000000000 1.570796327\n");
}

TEST(ReadSession, AFileWithoutLoopsIsNamed) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "loops_empty.lcmlog";
  std::ofstream(file, std::ios::binary) << "no log";
  EXPECT_THROW(read_session(file), std::runtime_error);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace fusion_slam
