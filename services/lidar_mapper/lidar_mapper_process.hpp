// The LiDAR mapper on the bus: LIDAR, ROBOT_MODEL, ODOMETRY, VISUAL_POSE and COMMAND in;
// LIDAR_POSE, LIDAR_NODE and SUBMAP tiles out.
#pragma once

#include <deque>
#include <optional>

#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/journal_mark.hpp"
#include "libs/bus/reset_gate.hpp"
#include "libs/bus/tile_channel.hpp"
#include "services/lidar_mapper/lidar_mapper.hpp"

namespace fusion_slam {

class LidarMapperProcess {
 public:
  explicit LidarMapperProcess(Bus& bus);

 private:
  void on_robot_model(const robot_model_t& message);
  void on_scan(const bot_core::planar_lidar_t& message);
  void on_odometry(const bot_core::pose_t& message);
  void on_visual_pose(const pose_estimate_t& message);
  void on_command(const command_t& message);

  void on_earlier_node(const lidar_node_t& message);
  // Handles waiting scans up to `utime_us`: the model must be known.
  void handle_scans(std::int64_t utime_us);
  bool odometry_is_coming(std::int64_t utime_us) const;
  void publish(const MapperOutput& output);
  void publish(const std::vector<Tile>& tiles);
  void say_state();

  Bus& bus_;
  ResetGate reset_{"lidar_mapper"};
  SourceIds ids_;  // of nodes, by the journal
  TilePublisher submap_tiles_;
  std::deque<LidarNode> earlier_;      // last nodes of an earlier process, by the journal
  std::optional<LidarMapper> mapper_;  // made when the first ROBOT_MODEL comes
  // Scans that wait for the model, or for the odometry of their time.
  std::deque<LaserScan> waiting_;
  std::int64_t dropped_waiting_ = 0;
  std::optional<std::int64_t> newest_odometry_us_;
};

}  // namespace fusion_slam
