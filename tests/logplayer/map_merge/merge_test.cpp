#include "logplayer/map_merge/merge.hpp"

#include "libs/map_directory/map_reader.hpp"
#include "tests/libs/localization/flat_world.hpp"
#include "tests/libs/map_directory/session_log.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

// A LiDAR session along a way through a world, saved as a map: its frame is the first pose's.
fs::path save_drive(const fs::path& place, const FlatWorld& world, const std::vector<SE2>& way) {
  fs::create_directories(place);
  const fs::path file = place / "session.lcmlog";
  LogWriter writer(file);
  RobotModel robot;
  robot.has_lidar = true;
  log(&writer, 1, "ROBOT_MODEL", to_message(robot, kSessionUs));
  const SE2 T_map_world = way.front().inverse();
  graph_t graph{};
  graph.revision = 1;
  graph.n_parts = 1;
  SE3 T_map_previous = SE3::Identity();
  for (std::size_t i = 0; i < way.size(); ++i) {
    const auto id = static_cast<std::int64_t>(i) + 1;
    const SE3 T_map_base = to_se3(T_map_world * way[i]);
    lidar_node_t node = node_of(id, 0.0);
    node.utime = kSessionUs + id * 300'000;
    node.T_odom_base = to_message(T_map_base, node.utime);
    node.T_previous_base = to_message(T_map_previous.inverse() * T_map_base, node.utime);
    to_message(Matrix6d(Matrix6d::Identity() * 1e-4), node.covariance);
    node.submap_ids = {1};
    node.T_submap_base = {to_message(T_map_base, node.utime)};
    node.n_submaps = 1;
    for (const auto& p : scan_of(world, way[i], static_cast<unsigned>(id))) {
      node.x_m.push_back(static_cast<float>(p.x()));
      node.y_m.push_back(static_cast<float>(p.y()));
    }
    node.n_points = static_cast<std::int32_t>(node.x_m.size());
    pose_estimate_t pose = pose_of(id);
    pose.utime = node.utime;
    pose.T_frame_base = node.T_odom_base;
    log(&writer, node.utime, "LIDAR_NODE", node);
    log(&writer, node.utime, "LIDAR_POSE", pose);
    graph_node_t out{};
    out.kind = graph_node_t::LIDAR;
    out.id = id;
    out.utime = node.utime;
    out.T_map_base = node.T_odom_base;
    graph.nodes.push_back(out);
    T_map_previous = T_map_base;
  }
  graph.n_nodes = static_cast<std::int32_t>(graph.nodes.size());
  const TiledGrid grid = grid_of(world, T_map_world);
  for (const auto& [index, cells] : grid.tiles())
    for (const std::int64_t submap : {1, 0})
      log(&writer, kSessionUs, submap == 1 ? "SUBMAP" : "GRID_LIDAR",
          to_message(encode_grid_tile({submap, index.first, index.second, 0}, cells, 0.05, 1,
                                      kSessionUs)));
  log(&writer, kSessionUs, "GRAPH", graph);
  writer.close();
  save_session(file, place / "map", {});
  return place / "map";
}

std::vector<SE2> backwards(std::vector<SE2> way) {
  std::reverse(way.begin(), way.end());
  for (SE2& T : way) T.yaw = wrap_angle(T.yaw + M_PI);
  return way;
}

TEST(Merge, TwoDrivesThroughOnePlace) {
  const fs::path place = scratch();
  const FlatWorld world = flat();
  const auto there = way_through(), back = backwards(there);
  const fs::path a = save_drive(place / "a", world, there),
                 b = save_drive(place / "b", world, back);
  const auto before_a = contents(a), before_b = contents(b);

  const MergeReport report = merge_maps(a, b, place / "joined");
  EXPECT_EQ(contents(a), before_a);
  EXPECT_EQ(contents(b), before_b);
  EXPECT_GE(report.cross_loops, 3);
  EXPECT_EQ(report.switched_off, 0);
  EXPECT_GT(report.shifted_s, 0.0);  // both began at one moment
  EXPECT_EQ(report.summary.sessions, 2);
  EXPECT_EQ(report.summary.submaps, 2);

  const MapState state = read_state(MapReader(place / "joined"));
  const auto nodes = state.graph.T_map_nodes();
  ASSERT_EQ(nodes.size(), there.size() + back.size());  // no id twice
  const SE2 T_map_world = there.front().inverse();
  for (const auto& [id, T_map_base] : nodes) {
    const auto i = static_cast<std::size_t>(id.id - 1);
    const SE2 truth = T_map_world * (i < there.size() ? there[i] : back[i - there.size()]);
    EXPECT_NEAR(T_map_base.translation().x(), truth.x, 0.05) << id.id;
    EXPECT_NEAR(T_map_base.translation().y(), truth.y, 0.05) << id.id;
    EXPECT_NEAR(wrap_angle(to_se2(T_map_base).yaw - truth.yaw), 0.0, 0.03) << id.id;
  }
  std::string why;
  EXPECT_TRUE(state.maps.grid_of("GRID_LIDAR", &why)) << why;
  EXPECT_TRUE(state.maps.grid_of("GRID_FUSED", &why)) << why;

  // What was joined can be joined again, in place.
  EXPECT_EQ(merge_maps(place / "joined", b, place / "joined").summary.sessions, 3);
}

TEST(Merge, RefusesWhatDoesNotOverlap) {
  const fs::path place = scratch();
  const fs::path a = save_drive(place / "a", flat(), way_through());
  FlatWorld other;
  other.width_m = 3.0, other.height_m = 3.0;
  other.walls = {
      {{0, 0}, {2.1, 0.4}}, {{2.1, 0.4}, {2.6, 2}}, {{2.6, 2}, {0.5, 2.9}}, {{0.5, 2.9}, {0, 0}}};
  std::vector<SE2> way;
  for (int i = 0; i < 8; ++i) way.push_back({1.0 + 0.1 * i, 1.0 + 0.05 * i, 0.4});
  const fs::path b = save_drive(place / "b", other, way);
  const std::string error = error_of([&] { merge_maps(a, b, place / "joined"); });
  EXPECT_NE(error.find("no overlap is proven"), std::string::npos) << error;
  EXPECT_FALSE(fs::exists(place / "joined"));
}

}  // namespace
}  // namespace fusion_slam
