#include <random>

#include <gtest/gtest.h>

#include "libs/messages/convert.hpp"
#include "viz/web/graph_view.hpp"
#include "viz/web/grid_view.hpp"
#include "viz/web/health_view.hpp"
#include "viz/web/truth_view.hpp"
#include "viz/web/viewer_state.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::json;

Json json_of(const ItemStore& store, Topic topic, const std::string& key) {
  const auto payload = store.find(topic, key);
  return payload ? Json::parse(*payload) : Json();
}

graph_node_t node(int kind, std::int64_t id, double x_m) {
  graph_node_t message{};
  message.kind = static_cast<std::int8_t>(kind);
  message.id = id;
  message.utime = id * 100'000;
  message.T_map_base = to_message(make_pose({x_m, 0.0, 0.0}, 1.0, 0.0, 0.0, 0.0), message.utime);
  return message;
}

graph_t graph(std::int64_t revision, std::vector<graph_node_t> nodes, bool complete = false) {
  graph_t message{};
  message.revision = revision;
  message.complete = complete ? 1 : 0;
  message.n_parts = 1;
  message.nodes = std::move(nodes);
  message.n_nodes = static_cast<std::int32_t>(message.nodes.size());
  return message;
}

loop_candidate_t candidate(std::int64_t from, std::int64_t to, bool accepted) {
  loop_candidate_t message{};
  message.from_kind = message.to_kind = graph_node_t::KEYFRAME;
  message.from_id = from;
  message.to_id = to;
  message.accepted = accepted ? 1 : 0;
  stage_verdict_t stage{};
  stage.stage = "appearance";
  stage.score = 0.4;
  stage.reason = "bytes that are no text: \xff";
  message.stages = {stage};
  message.n_stages = 1;
  return message;
}

TEST(GraphView, AMovedNodeChangesItsChunkOnly) {
  ItemStore store;
  GraphView view(store);
  std::vector<graph_node_t> nodes;
  for (int id = 1; id <= 200; ++id) nodes.push_back(node(0, id, id));
  view.on_graph(graph(1, nodes));
  EXPECT_EQ(store.size(Topic::kNodes), 4U);  // ids 1..63, 64..127, 128..191, 192..200
  EXPECT_EQ(store.find(Topic::kNodes, "k3")->size(), 9U * 44U);
  Cursor cursor;
  store.next(&cursor, TopicSet().set(), 1 << 20);
  view.on_graph(graph(2, {node(0, 70, 1.0), node(0, 71, 71.0)}));
  const auto items = store.next(&cursor, TopicSet().set(), 1 << 20);
  ASSERT_EQ(items.size(), 1U);
  EXPECT_EQ(items[0].key, "k1");
}

TEST(GraphView, ARestartedGraphForgetsTheOldOne) {
  ItemStore store;
  GraphView view(store);
  view.on_graph(graph(9, {node(0, 1, 1.0), node(1, 1, 1.0)}));
  view.on_candidate(candidate(1, 2, true));
  view.on_graph(graph(0, {}, true));
  EXPECT_TRUE(view.nodes().empty());
  EXPECT_EQ(store.size(Topic::kNodes) + store.size(Topic::kLoop), 0U);
}

TEST(GraphView, IdsThatCanNotBeAreLeftOut) {
  ItemStore store;
  GraphView view(store);
  view.on_graph(graph(1, {node(2, 1, 0.0), node(0, -5, 0.0), node(0, 5'000'000'000, 0.0)}));
  EXPECT_TRUE(view.nodes().empty());
}

TEST(GraphView, ALoopsWayFromIdeaToClosureToSwitchedOff) {
  ItemStore store;
  GraphView view(store);
  view.on_candidate(candidate(3, 90, true));
  EXPECT_EQ(json_of(store, Topic::kLoop, "k3-k90")["state"], "closed");
  constraint_t measured{};
  measured.from_kind = measured.to_kind = graph_node_t::KEYFRAME;
  measured.from_id = 3;
  measured.to_id = 90;
  measured.source = "geometry";
  view.on_constraint(measured);
  EXPECT_EQ(json_of(store, Topic::kLoop, "k3-k90")["source"], "geometry");
  EXPECT_EQ(view.loops_closed(), 1U);
  graph_t off = graph(2, {});
  loop_state_t state{};
  state.from_id = 3;
  state.to_id = 90;
  state.squared_error = 55.0;
  state.reason = "outvoted";
  off.switched_off = {state};
  off.n_switched_off = 1;
  view.on_graph(off);
  EXPECT_EQ(json_of(store, Topic::kLoop, "k3-k90")["state"], "switched_off");
  EXPECT_EQ(json_of(store, Topic::kLoop, "k3-k90")["off_reason"], "outvoted");
  EXPECT_EQ(view.loops_closed(), 0U);
  view.on_graph(graph(3, {}));
  EXPECT_EQ(json_of(store, Topic::kLoop, "k3-k90")["state"], "closed");
}

TEST(GraphView, RejectedCandidatesAreBounded) {
  ItemStore store;
  GraphView view(store);
  view.on_candidate(candidate(1, 2, true));
  for (int i = 0; i < 1000; ++i) view.on_candidate(candidate(5, 100 + i, false));
  EXPECT_EQ(store.size(Topic::kLoop), GraphView::kMostRejected + 1);
  EXPECT_TRUE(store.find(Topic::kLoop, "k1-k2"));
  EXPECT_TRUE(store.find(Topic::kLoop, "k5-k1099"));
}

status_t status(const std::string& process, std::int64_t utime_us, std::int64_t processed) {
  status_t message{};
  message.utime = utime_us;
  message.process = process;
  message.pid = 7;
  message.state = status_t::RUNNING;
  channel_stats_t channel{};
  channel.channel = "LIDAR";
  channel.subscribed = 1;
  channel.processed = processed;
  channel.last_utime = utime_us - 2'000'000;
  message.channels = {channel};
  message.n_channels = 1;
  return message;
}

TEST(HealthView, RatesAreDifferencesAndSilenceIsSaid) {
  ItemStore store;
  HealthView view(store);
  view.on_input("LIDAR", 9'000'000, 1000, 10'000'000);
  view.on_status(status("fuser", 10'000'000, 100), 10'000'000);
  view.on_status(status("fuser", 12'000'000, 160), 12'000'000);
  Json json = json_of(store, Topic::kHealth, "fuser");
  EXPECT_DOUBLE_EQ(json["rate_hz"], 30.0);
  EXPECT_EQ(json["state"], "running");
  view.tick(16'000'000);
  EXPECT_EQ(json_of(store, Topic::kHealth, "fuser")["state"], "running");
  view.tick(18'000'000);
  json = json_of(store, Topic::kHealth, "fuser");
  EXPECT_EQ(json["state"], "silent");
  EXPECT_DOUBLE_EQ(json["silent_s"], 6.0);
}

TEST(HealthView, AnInputThatStopsIsLateByHowLongItIsSilent) {
  ItemStore store;
  HealthView view(store);
  for (int i = 0; i <= 30; ++i) view.on_input("LIDAR", i * 100'000, 1000, i * 100'000);
  view.tick(3'200'000);
  Json json = json_of(store, Topic::kInput, "LIDAR");
  EXPECT_NEAR(json["rate_hz"], 10.0, 1e-9);
  EXPECT_NEAR(json["bytes_s"], 10'000.0, 1e-6);
  EXPECT_FALSE(json["late"]);
  view.tick(4'500'000);
  json = json_of(store, Topic::kInput, "LIDAR");
  EXPECT_TRUE(json["late"]);
  EXPECT_NEAR(json["late_s"], 1.5, 1e-9);
}

TEST(HealthView, AnInputBehindTheOthersIsLateThoughItComes) {
  ItemStore store;
  HealthView view(store);
  for (int i = 0; i <= 30; ++i) {
    view.on_input("LIDAR", i * 100'000, 1000, i * 100'000);
    view.on_input("CAMERA", i * 100'000 - 2'000'000, 1000, i * 100'000);
  }
  view.tick(3'000'000);
  EXPECT_FALSE(json_of(store, Topic::kInput, "LIDAR")["late"]);
  EXPECT_NEAR(json_of(store, Topic::kInput, "CAMERA")["late_s"], 2.0, 1e-9);
}

FusedCells random_cells(std::mt19937& random) {
  FusedCells cells;
  for (std::size_t i = 0; i < cells.probability.size(); ++i) {
    cells.probability[i] = static_cast<std::uint8_t>(random() % 256);
    cells.provenance[i] = static_cast<std::uint8_t>(random() % 5);
  }
  return cells;
}

// Every cell of every tile, negative ones among them, against plain arithmetic.
TEST(GridView, FindsTheCellUnderAPoint) {
  std::mt19937 random(3);
  GridView view;
  std::map<TileIndex, FusedCells> cells;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 0; ++y) {
      cells[{x, y}] = random_cells(random);
      ASSERT_TRUE(view.on_tile(GridView::Layer::kFused,
                               encode_fused_tile({0, x, y, 0}, cells[{x, y}], 0.05, 1, 5'000'000)));
    }
  for (int cell_x = -64; cell_x < 128; ++cell_x)
    for (int cell_y = -64; cell_y < 64; cell_y += 3) {
      const auto report = view.at((cell_x + 0.5) * 0.05, (cell_y + 0.5) * 0.05);
      ASSERT_TRUE(report);
      ASSERT_EQ(report->cell_x, cell_x);
      ASSERT_EQ(report->cell_y, cell_y);
      const int tile_x = (cell_x + 64) / 64 - 1;
      const int tile_y = (cell_y + 64) / 64 - 1;
      const FusedCells& tile = cells[{tile_x, tile_y}];
      const auto i = static_cast<std::size_t>((cell_y - 64 * tile_y) * 64 + cell_x - 64 * tile_x);
      if (tile.probability[i] == kUnknownCell)
        ASSERT_FALSE(report->fused);
      else
        ASSERT_DOUBLE_EQ(*report->fused, probability_from_cell(tile.probability[i]));
      ASSERT_EQ(static_cast<int>(report->provenance), tile.provenance[i]);
    }
  EXPECT_FALSE(view.at(50.0, 50.0));
  EXPECT_FALSE(view.at(std::nan(""), 0.0));
}

TEST(GridView, KnowsWhenACellWasFirstSeenAndLastChanged) {
  GridView view;
  FusedCells cells;
  cells.probability[0] = 200;
  view.on_tile(GridView::Layer::kFused, encode_fused_tile({0, 0, 0, 0}, cells, 0.05, 1, 1'000'000));
  cells.probability[1] = 90;  // another cell
  view.on_tile(GridView::Layer::kFused, encode_fused_tile({0, 0, 0, 0}, cells, 0.05, 2, 2'000'000));
  cells.probability[0] = 10;
  view.on_tile(GridView::Layer::kFused, encode_fused_tile({0, 0, 0, 0}, cells, 0.05, 3, 3'000'000));
  view.on_tile(GridView::Layer::kFused,
               encode_fused_tile({0, 0, 0, 0}, FusedCells(), 0.05, 2, 9'000'000));
  const auto report = view.at(0.02, 0.02);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->first_seen_us, 1'000'000);
  EXPECT_EQ(report->last_changed_us, 3'000'000);
  EXPECT_EQ(report->changes, 2);
  EXPECT_NEAR(view.known_area_m2(), 2 * 0.05 * 0.05, 1e-12);
  Tile damaged = encode_fused_tile({0, 1, 0, 0}, cells, 0.05, 1, 0);
  damaged.data.resize(damaged.data.size() / 2);
  EXPECT_FALSE(view.on_tile(GridView::Layer::kFused, damaged));
}

TEST(TruthView, IsMovedOntoTheGraph) {
  ItemStore store;
  TruthView view(store);
  std::map<NodeId, GraphView::Node> nodes;
  const SE3 T_map_truth = from_xyz_rpy(3.0, -2.0, 0.5, 0.0, 0.0, 1.0);
  for (int i = 0; i <= 100; ++i) {
    const SE3 T_truth_base =
        from_xyz_rpy(0.1 * i, std::sin(0.1 * i), 0.1 * std::cos(0.3 * i), 0.0, 0.0, 0.02 * i);
    view.on_truth(i * 100'000, T_truth_base);
    if (i % 10 != 0) continue;
    GraphView::Node& node = nodes[{NodeKind::kKeyframe, i + 1}];
    node.utime_us = i * 100'000;
    node.T_map_base = T_map_truth * T_truth_base;
  }
  view.align(nodes);
  const Json json = json_of(store, Topic::kTruth, "alignment");
  EXPECT_NEAR(json["rmse_m"], 0.0, 1e-9);
  EXPECT_NEAR(json["t"][0], 3.0, 1e-6);
  EXPECT_NEAR(view.newest()->translation().x(),
              (T_map_truth * Eigen::Vector3d(10.0, std::sin(10.0), 0.1 * std::cos(30.0))).x(),
              1e-6);
}

TEST(ViewerState, DamagedTilesAreCountedAndNotSent) {
  ItemStore store;
  ViewerState state(store);
  Tile tile;
  tile.encoding = TileEncoding::kGridFused;
  tile.data = {1, 2, 3};
  state.on_tile("GRID_FUSED", tile);
  state.tick();
  EXPECT_EQ(store.size(Topic::kGridFused), 0U);
  EXPECT_EQ(json_of(store, Topic::kTime, "session")["damaged_tiles"], 1);
}

TEST(ViewerState, NoticesAreBounded) {
  ItemStore store;
  ViewerState state(store);
  for (int i = 0; i < 100; ++i) state.notice("info", "text " + std::to_string(i));
  EXPECT_EQ(store.size(Topic::kNotice), 20U);
}

TEST(ViewerState, AUnknownCellIsSaidToBe) {
  ItemStore store;
  ViewerState state(store);
  EXPECT_EQ(Json::parse(state.cell_json(1.0, 2.0))["known"], false);
}

TEST(ViewerState, ResetTakesTheMapAndLeavesTheProcesses) {
  ItemStore store;
  ViewerState state(store);
  status_t status{};
  status.process = "fuser";
  state.on("STATUS", status);
  state.on("GRAPH", graph(3, {node(0, 1, 1.0)}));
  state.on("LOOP_CANDIDATE", candidate(1, 2, true));
  FusedCells cells;
  cells.probability.fill(200);
  Tile tile = encode_fused_tile({0, 0, 0, 0}, cells, 0.05, 1, 100'000);
  state.on_tile("GRID_FUSED", tile);
  ASSERT_EQ(store.size(Topic::kGridFused), 1U);
  command_t reset{};
  reset.utime = 200'000;
  reset.verb = "reset";
  state.on("COMMAND", reset);
  EXPECT_EQ(store.size(Topic::kGridFused) + store.size(Topic::kNodes) + store.size(Topic::kLoop),
            0U);
  EXPECT_EQ(store.size(Topic::kHealth), 1U);
  EXPECT_EQ(Json::parse(state.cell_json(0.1, 0.1))["known"], false);
  state.on("LOOP_CANDIDATE", candidate(1, 2, true));  // of before: its utime is 0
  EXPECT_EQ(store.size(Topic::kLoop), 0U);
  state.on("GRAPH", graph(1, {node(0, 3, 0.0)}));
  EXPECT_EQ(store.size(Topic::kNodes), 1U);
}

TEST(ViewerState, WhatTheLabMayStartIsShownThoughTheDeputyHasForgottenIt) {
  ItemStore store;
  ViewerState state(store);
  state.set_lab(
      parse_lab_config("cmd \"a\" { exec = \"x\"; deputy = \"robot\"; } cmd \"b\" { exec = \"x\"; "
                       "deputy = \"other\"; }",
                       "lab.cfg"));
  procman_lcm::deputy_info_t info{};
  info.deputy_id = "robot";
  state.on("PM_INFO", info);
  Json commands = json_of(store, Topic::kDeputy, "robot")["commands"];
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_EQ(commands[0]["name"], "a");
  info.cmds.resize(1);
  info.cmds[0].cmd.command_id = "a";
  info.cmds[0].pid = 5;
  info.ncmds = 1;
  state.on("PM_INFO", info);
  commands = json_of(store, Topic::kDeputy, "robot")["commands"];
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_EQ(commands[0]["pid"], 5);
}

TEST(ViewerState, LocalizationSaysWhereAndHowSure) {
  ItemStore store;
  ViewerState state(store);
  pose_estimate_t message{};
  message.utime = 5'000'000;
  message.state = pose_estimate_t::WEAK;
  message.reason = "CANDIDATE: two places look alike";
  message.T_frame_base = to_message(make_pose({1.0, 2.0, 0.0}, 1.0, 0.0, 0.0, 0.0), 5'000'000);
  message.n_matched = 81;
  state.on("LOCALIZATION", message);
  Json json = json_of(store, Topic::kPose, "localization");
  EXPECT_EQ(json["state"], "candidate");
  EXPECT_EQ(json["reason"], "two places look alike");
  EXPECT_EQ(json["score_percent"], 81);
  EXPECT_DOUBLE_EQ(json["t"][1].get<double>(), 2.0);
  message.state = pose_estimate_t::UNKNOWN;
  state.on("LOCALIZATION", message);
  json = json_of(store, Topic::kPose, "localization");
  EXPECT_EQ(json["state"], "unknown");
  EXPECT_EQ(json.count("t"), 0U);
}

}  // namespace
}  // namespace fusion_slam
