// The localizer on the bus: LIDAR_NODE, LIDAR_POSE, KEYFRAME, VISUAL_POSE, COMMAND and a map
// directory in; POSE, LOCALIZATION, GRAPH (nodes of this session, placed in the map) and the map's
// own tiles out. The map is only read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/localization/localizer.hpp"
#include "libs/map_directory/map_publisher.hpp"
#include "libs/map_directory/map_reader.hpp"

namespace fusion_slam {

// LOCALIZATION is a pose_estimate_t; its reason begins with one of these words.
const char* name_of(LocalizationState state);        // UNKNOWN, CANDIDATE, LOCALIZED
std::int8_t pose_state_of(LocalizationState state);  // UNKNOWN, WEAK, OK

class LocalizerProcess {
 public:
  // Reads and checks the map whole, then publishes it. Throws std::runtime_error, for people.
  LocalizerProcess(Bus& bus, const std::filesystem::path& map_directory);

 private:
  void on_lidar_node(const lidar_node_t& message);
  void on_keyframe(const keyframe_t& message);
  void on_pose(NodeKind sensor, const pose_estimate_t& message);
  void on_robot_model(const robot_model_t& message);
  void on_camera_model(const camera_model_t& message);
  void on_command(const command_t& message);
  void publish_news(std::int64_t utime_us);
  void publish_graph(const std::vector<graph_node_t>& nodes, bool complete);
  void publish_all_nodes();
  void publish_localization(std::int64_t utime_us);
  void publish_pose(const pose_estimate_t& message);

  Bus& bus_;
  MapReader reader_;
  MapState state_;
  LocalizationMap map_;
  Localizer localizer_;
  std::int64_t revision_ = 0;
  std::int64_t newest_us_ = 0;
  std::string said_;  // state and reason last published
  bool camera_checked_ = false;
};

}  // namespace fusion_slam
