// The pose graph on the bus: its inputs to PoseGraph, GRAPH and POSE out.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/journal_note_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/reset_gate.hpp"
#include "services/pose_graph/clock_watch.hpp"
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

class PoseGraphProcess {
 public:
  explicit PoseGraphProcess(Bus& bus);

 private:
  void on_robot(const robot_model_t& message);
  void on_camera(const camera_model_t& message);
  void on_keyframe(const keyframe_t& message);
  void on_lidar_node(const lidar_node_t& message);
  void on_pose(NodeKind sensor, const pose_estimate_t& message);
  void on_odometry(const bot_core::pose_t& message);
  void on_constraint(const constraint_t& message);
  void on_level(const constraint_t& message);
  void on_command(const command_t& message);

  // pose_graph_journal.cpp
  void keep_journal();
  void on_earlier_graph(const graph_t& message);
  void write_down();
  void restore_state();
  void follow_recovery();

  void publish_news();
  void publish_complete();
  void publish_to_late_ones();
  void publish_graph(const std::vector<graph_node_t>& nodes, bool complete, bool is_news = true);
  void publish_pose(const PoseOutput& pose);
  void reject(const char* channel, const char* why);
  void say_state();

  Bus& bus_;
  ResetGate reset_{"pose_graph"};
  std::map<NodeKind, ClockWatch> clock_;
  PoseGraph graph_;
  std::int64_t revision() const;     // as published: never lower than what was published before
  std::vector<std::uint8_t> saved_;  // the journal's: of an earlier process, not restored yet
  PoseGraph::Earlier earlier_;       // what became of that, or of the empty graph, since
  bool rebuild_begun_ = false;
  std::int64_t solves_ = 0;            // when memory was last given back
  std::int64_t last_complete_ = 0;     // revision of graph_
  NodeId last_told_;                   // the nodes behind it are said next
  std::map<std::string, int> peers_;   // process and its number; the reader's thread alone
  std::atomic<bool> newcomer_{false};  // one that knows nothing of the graph yet
  std::int64_t earlier_revision_ = 0;  // the last of an earlier graph
};

}  // namespace fusion_slam
