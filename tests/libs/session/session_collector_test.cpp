#include "libs/session/session_collector.hpp"

#include <gtest/gtest.h>

#include "libs/grid/fused_tile.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "libs/octree/octomap_tile.hpp"
#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kStartUs = 1'700'000'000'000'001;

SE3 at_x(double x) { return from_xyz_rpy(x, 0, 0, 0, 0, 0); }

pose_estimate_t pose(std::int64_t utime_us, std::int64_t keyframe, const SE3& T) {
  pose_estimate_t m{};
  m.utime = utime_us;
  m.T_frame_base = to_message(T, utime_us);
  m.T_reference_base = to_message(T, utime_us);
  m.state = pose_estimate_t::OK;
  m.reference_kind = graph_node_t::KEYFRAME;
  m.reference_id = keyframe;
  return m;
}

graph_t graph(std::int64_t revision, std::int64_t id, const SE3& T) {
  graph_t m{};
  m.revision = revision;
  graph_node_t node{};
  node.kind = graph_node_t::KEYFRAME;
  node.id = id;
  node.T_map_base = to_message(T, 0);
  m.nodes = {node};
  m.n_nodes = 1;
  return m;
}

Tile fused_tile(std::int64_t revision, double probability) {
  FusedCells cells;
  cells.probability[70] = cell_from_probability(probability);
  cells.provenance[70] = static_cast<std::uint8_t>(Provenance::kBoth);
  return encode_fused_tile({0, 0, 0, 0}, cells, 0.05, revision, 0);
}

// A camera 1 m above the base, looking ahead; three frames on two keyframes; the graph was
// corrected after frame 3.
void feed(SessionCollector* session) {
  RobotModel robot;
  robot.has_camera = true;
  robot.reference_frame = ReferenceFrame::kCamera;
  robot.T_base_camera.linear() = optical_to_body();
  robot.T_base_camera.translation() = Eigen::Vector3d(0, 0, 1);
  session->on_robot_model(to_message(robot, 0));
  for (const std::int64_t utime_us : {kStartUs, kStartUs + 499'999, kStartUs + 999'999})
    session->on_camera(utime_us);
  session->on_graph(graph(1, 1, SE3::Identity()));
  session->on_visual_pose(pose(kStartUs, 1, SE3::Identity()));
  session->on_pose(pose(kStartUs, 1, SE3::Identity()));
  session->on_visual_pose(pose(kStartUs + 499'999, 1, at_x(0.25)));
  session->on_visual_pose(pose(kStartUs + 999'999, 2, at_x(0.5)));
  session->on_graph(graph(3, 2, from_xyz_rpy(1, 0, 0, 0, 0, M_PI / 2)));
  session->on_graph(graph(2, 2, at_x(77.0)));  // late and old
}

void feed_maps(SessionCollector* session) {
  session->on_tile("GRID_FUSED", fused_tile(2, 0.9));
  session->on_tile("GRID_FUSED", fused_tile(1, 0.1));  // late and old
  for (const char* channel : {"GRID_LIDAR", "GRID_VISUAL"}) {
    TileCells cells{};
    cells[0] = cell_from_probability(channel[5] == 'L' ? 0.9 : 0.1);
    session->on_tile(channel, encode_grid_tile({0, 0, 0, 0}, cells, 0.05, 1, 0));
  }
  VoxelCells voxels;
  voxels.fill(kUnknownVoxel);
  voxels[5] = 64;
  session->on_tile("OCTOMAP", to_message(encode_octomap_tile({0, 1, 0, 0}, voxels, 0.05, 1, 0)));
  const std::vector<ColouredPoint> points{{{0.1F, 0.2F, 0.3F}, 1, 2, 3}};
  session->on_tile("CLOUD", encode_cloud_tile({0, 0, 0, 0}, points, 0.05, 1, 0));
}

TEST(SessionCollector, GoldenTrajectoryInTheReferenceFrame) {
  SessionCollector session;
  feed(&session);
  const auto directory = scratch();
  const SessionResult result = session.write(directory);
  EXPECT_EQ(read_bytes(directory / "trajectory.tum"),
            read_bytes(std::filesystem::path(FS_SOURCE_DIR) /
                       "tests/libs/session/golden/trajectory.tum"));
  EXPECT_EQ(result.trajectory_poses, 3U);
  EXPECT_DOUBLE_EQ(result.coverage_percent, 100.0);
  EXPECT_EQ(result.graph_revision, 3);
  EXPECT_EQ(result.live_poses, 1U);
}

TEST(SessionCollector, WhatIsNotThereIsNamed) {
  SessionCollector session;
  feed(&session);
  const auto directory = scratch();
  const SessionResult result = session.write(directory);
  EXPECT_EQ(result.files, (std::vector<std::string>{"trajectory.tum", "live.tum"}));
  ASSERT_EQ(result.missing.size(), 10U);
  for (const MissingFile& missing : result.missing) {
    EXPECT_FALSE(missing.reason.empty());
    EXPECT_FALSE(std::filesystem::exists(directory / missing.name)) << missing.name;
  }
  EXPECT_EQ(result.missing[0].name, "groundtruth.tum");
}

TEST(SessionCollector, NothingAtAllIsAResult) {
  const SessionResult result = SessionCollector().write(scratch());
  EXPECT_TRUE(result.files.empty());
  EXPECT_EQ(result.missing.size(), 12U);
  EXPECT_EQ(result.coverage_percent, 0.0);
}

TEST(SessionCollector, AllFilesTwiceTheSameBytes) {
  SessionCollector session;
  feed(&session);
  feed_maps(&session);
  session.on_ground_truth(to_pose_message(at_x(3.0), kStartUs));
  const auto directory = scratch();
  const SessionResult result = session.write(directory / "a");
  session.write(directory / "b");
  session.write(directory / "b");  // and over itself
  ASSERT_EQ(result.files.size(), 12U);
  EXPECT_TRUE(result.missing.empty());
  const std::string lidar = read_bytes(directory / "a" / "lidar_map.pgm");
  EXPECT_EQ(lidar.substr(lidar.size() - 9), std::string("1 1\n255\n\0", 9));
  const std::string visual = read_bytes(directory / "a" / "visual_map.pgm");
  EXPECT_EQ(visual.substr(visual.size() - 9), "1 1\n255\n\xFE");
  EXPECT_NE(read_bytes(directory / "a" / "visual_map.yaml").find("image: visual_map.pgm"),
            std::string::npos);
  EXPECT_EQ(result.map_source, "GRID_FUSED");
  EXPECT_EQ(result.cloud_points, 1U);
  EXPECT_NEAR(result.occupied_area_m2, 0.0025, 1e-12);
  for (const std::string& name : result.files)
    EXPECT_EQ(read_bytes(directory / "a" / name), read_bytes(directory / "b" / name)) << name;
  // Cell 70 is column 6 of row 1: the newer tile, occupied, is the only known cell.
  const std::string pgm = read_bytes(directory / "a" / "map.pgm");
  EXPECT_EQ(pgm.substr(pgm.size() - 9), std::string("1 1\n255\n\0", 9));
  const std::string yaml = read_bytes(directory / "a" / "map.yaml");
  EXPECT_NE(yaml.find("origin: [0.3, 0.05, 0]"), std::string::npos) << yaml;
}

TEST(SessionCollector, TheBestGridIsTaken) {
  SessionCollector session;
  TileCells cells{};
  cells[0] = cell_from_probability(0.9);
  session.on_tile("GRID_VISUAL", encode_grid_tile({0, 0, 0, 0}, cells, 0.05, 1, 0));
  EXPECT_EQ(session.write(scratch()).map_source, "GRID_VISUAL");
  session.on_tile("GRID_LIDAR", encode_grid_tile({0, 0, 0, 0}, cells, 0.05, 1, 0));
  EXPECT_EQ(session.write(scratch()).map_source, "GRID_LIDAR");
  Tile gone = fused_tile(1, 0.9);
  session.on_tile("GRID_FUSED", gone);
  gone.revision = 2;
  gone.encoding = TileEncoding::kEmpty;
  gone.data.clear();
  session.on_tile("GRID_FUSED", gone);
  EXPECT_EQ(session.write(scratch()).map_source, "GRID_LIDAR");
}

TEST(SessionCollector, DamageIsCountedNotBelieved) {
  SessionCollector session;
  feed(&session);
  Tile tile = fused_tile(5, 0.9);
  tile.data.resize(3);
  session.on_tile("GRID_FUSED", tile);
  pose_estimate_t bad = pose(kStartUs + 1, 1, SE3::Identity());
  bad.T_reference_base.quat[0] = NAN;
  session.on_visual_pose(bad);
  bot_core::pose_t truth{};
  session.on_ground_truth(truth);
  const SessionResult result = session.write(scratch());
  EXPECT_EQ(result.damaged_tiles, 1U);
  EXPECT_EQ(result.damaged_messages, 2U);
  EXPECT_EQ(result.trajectory_poses, 3U);
}

TEST(SessionCollector, CountsDroppedAndLostOfTheNewestStatus) {
  SessionCollector session;
  status_t status{};
  status.process = "fuser";
  status.pid = 7;
  channel_stats_t channel{};
  channel.dropped = 2;
  channel.lost = 1;
  status.channels = {channel, channel};
  status.n_channels = 2;
  session.on_status(status);
  status.seq = 1;
  status.channels[0].dropped = 5;
  session.on_status(status);
  EXPECT_EQ(session.dropped_total(), 7);
  EXPECT_EQ(session.lost_total(), 2);
}

TEST(SessionCollector, CountersThatCannotBeDoNotWrap) {
  SessionCollector session;
  channel_stats_t huge{};
  huge.dropped = std::numeric_limits<std::int64_t>::max();
  huge.lost = std::numeric_limits<std::int64_t>::min();
  status_t status{};
  status.channels = {huge, huge};
  status.n_channels = 2;
  session.on_status(status);
  EXPECT_EQ(session.dropped_total(), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(session.lost_total(), 0);
}

TEST(SessionCollector, PosesBeyondAnyMapAreDamage) {
  SessionCollector session;
  session.on_graph(graph(-1, 1, at_x(1e300)));
  session.on_pose(pose(kStartUs, 1, at_x(1e300)));
  session.on_visual_pose(pose(kStartUs, 1, at_x(0.0)));
  const SessionResult result = session.write(scratch());
  EXPECT_EQ(result.damaged_messages, 1U);
  EXPECT_EQ(result.trajectory_poses, 0U);
  EXPECT_EQ(result.live_poses, 0U);
}

TEST(SessionCollector, NodeOfANegativeRevisionIsWhereItWasSaidToBe) {
  SessionCollector session;
  session.on_graph(graph(-1, 1, at_x(2.0)));
  session.on_graph(graph(-2, 1, at_x(3.0)));
  session.on_visual_pose(pose(kStartUs, 1, at_x(0.0)));
  session.on_visual_pose(pose(kStartUs + 1, 1, at_x(1.0)));
  const auto directory = scratch();
  EXPECT_EQ(session.write(directory).trajectory_poses, 2U);
  EXPECT_NE(read_bytes(directory / "trajectory.tum").find(" 2.000000000 0.000000000"),
            std::string::npos);
}

}  // namespace
}  // namespace fusion_slam
