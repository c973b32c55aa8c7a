// A small session log: what services would have said in a few seconds.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "libs/eventlog/writer.hpp"
#include "libs/grid/tiled_grid.hpp"
#include "libs/map_directory/map_saver.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {

constexpr std::int64_t kSessionUs = 1'700'000'000'000'000;

template <class Message>
void log(LogWriter* writer, std::int64_t utime_us, const std::string& channel,
         const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  writer->write(utime_us, channel, bytes);
}

inline graph_t graph_of(std::int64_t revision, std::int64_t id, double x_m) {
  graph_t graph{};
  graph.utime = kSessionUs + id;
  graph.seq = revision;
  graph.revision = revision;
  graph.n_parts = 1;
  graph_node_t node{};
  node.kind = graph_node_t::LIDAR;
  node.id = id;
  node.utime = kSessionUs + id;
  node.T_map_base = to_message(from_xyz_rpy(x_m, 0, 0, 0, 0, 0), node.utime);
  graph.nodes = {node};
  graph.n_nodes = 1;
  return graph;
}

inline Tile grid_tile(const TileKey& key, std::int64_t revision, double probability) {
  TileCells cells{};
  cells[0] = cell_from_probability(probability);
  return encode_grid_tile(key, cells, 0.05, revision, kSessionUs);
}

inline lidar_node_t node_of(std::int64_t id, double x_m) {
  lidar_node_t node{};
  node.utime = kSessionUs + id;
  node.seq = id;
  node.id = id;
  node.previous_id = id - 1;
  node.T_odom_base = to_message(from_xyz_rpy(x_m, 0, 0, 0, 0, 0), node.utime);
  node.T_previous_base = to_message(SE3::Identity(), node.utime);
  return node;
}

inline pose_estimate_t pose_of(std::int64_t id) {
  pose_estimate_t pose{};
  pose.utime = kSessionUs + id;
  pose.seq = id;
  pose.state = pose_estimate_t::OK;
  pose.reference_kind = graph_node_t::LIDAR;
  pose.reference_id = id;
  pose.T_frame_base = to_message(SE3::Identity(), pose.utime);
  pose.T_reference_base = to_message(SE3::Identity(), pose.utime);
  return pose;
}

// Two nodes, the second moved once; two revisions of a tile; one message twice. `wall` makes two
// sessions differ.
inline std::filesystem::path write_session(const std::filesystem::path& directory,
                                           double wall = 0.9) {
  std::filesystem::create_directories(directory);
  const auto file = directory / "session.lcmlog";
  LogWriter writer(file);
  RobotModel robot;
  robot.name = "test robot";
  robot.has_lidar = true;
  log(&writer, 1, "ROBOT_MODEL", to_message(robot, kSessionUs));
  log(&writer, 2, "STATUS", to_message(robot, kSessionUs));  // not the journal's
  log(&writer, 3, "LIDAR_NODE", node_of(1, 0.0));
  log(&writer, 4, "LIDAR_POSE", pose_of(1));
  log(&writer, 5, "GRAPH", graph_of(1, 1, 0.0));
  log(&writer, 6, "SUBMAP", to_message(grid_tile({1, 0, 0, 0}, 1, 0.3)));
  log(&writer, 7, "LIDAR_NODE", node_of(2, 1.0));
  log(&writer, 8, "LIDAR_NODE", node_of(2, 1.0));  // sent again
  log(&writer, 9, "LIDAR_POSE", pose_of(2));
  log(&writer, 10, "GRAPH", graph_of(2, 2, 1.0));
  log(&writer, 11, "SUBMAP", to_message(grid_tile({1, 0, 0, 0}, 2, wall)));
  log(&writer, 12, "GRID_LIDAR", to_message(grid_tile({0, 0, 0, 0}, 1, wall)));
  log(&writer, 13, "GRAPH", graph_of(3, 2, 1.5));
  writer.close();
  return file;
}

// Names and bytes of all files of a directory.
inline std::map<std::string, std::string> contents(const std::filesystem::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    files[entry.path().filename().string()] = read_bytes(entry.path());
  return files;
}

inline std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace fusion_slam
