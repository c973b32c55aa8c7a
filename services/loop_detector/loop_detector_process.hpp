// Loop detection on the bus: KEYFRAME, LIDAR_NODE, SUBMAP and GRAPH in; LOOP_CANDIDATE out, and
// CONSTRAINT for candidates that are accepted.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/journal_note_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/reset_gate.hpp"
#include "libs/bus/tile_channel.hpp"
#include "services/loop_detector/loop_detector.hpp"
#include "services/loop_detector/loop_messages.hpp"

namespace fusion_slam {

// Keyframes and scans that come before ROBOT_MODEL (and, for keyframes, CAMERA_MODEL) wait for it.
// Both models are taken once.
class LoopDetectorProcess {
 public:
  explicit LoopDetectorProcess(Bus& bus, LoopDetectorConfig config = {});

 private:
  void on_camera_model(const camera_model_t& message);
  void on_robot_model(const robot_model_t& message);
  void on_keyframe(const keyframe_t& message);
  void on_lidar_node(const lidar_node_t& message);
  void on_graph(const graph_t& message);
  void on_command(const command_t& message);
  void start_when_ready();
  void keep_journal();
  void on_earlier_loop(const constraint_t& message);
  void on_saved(const journal_note_t& message);
  void write_down();
  void write_down_now_and_then();
  void go_on_where_it_ended();
  void take(const LoopKeyframe& keyframe);
  void take(const LoopScan& scan);
  void publish(const std::vector<LoopCandidate>& decided);
  void note_news();
  void say_state();

  Bus& bus_;
  ResetGate reset_{"loop_detector"};
  LoopDetectorConfig config_;
  TileReceiver submap_tiles_;
  std::optional<CameraModel> camera_;
  std::optional<RobotModel> robot_;
  std::unique_ptr<LoopDetector> detector_;
  std::vector<LoopKeyframe> early_keyframes_;
  std::vector<LoopScan> early_scans_;
  std::vector<Tile> early_tiles_;
  std::vector<std::uint8_t> saved_;  // an earlier process's state, by the journal
  int keyframes_since_written_ = 0;
  std::vector<LoopMeasurement> earlier_loops_;     // since then
  KnownPlacesNews earlier_places_;                 // likewise
  std::set<std::pair<NodeId, NodeId>> known_off_;  // loops that the graph has switched off
};

}  // namespace fusion_slam
