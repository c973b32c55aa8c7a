// The dense mapper on the bus: KEYFRAME_IMAGE, GRAPH, CAMERA_MODEL, ROBOT_MODEL, COMMAND in; CLOUD,
// OCTOMAP, GRID_VISUAL, LEVEL out.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/reset_gate.hpp"
#include "libs/bus/tile_channel.hpp"
#include "services/dense_mapper/dense_mapper.hpp"

namespace fusion_slam {

class DenseMapperProcess {
 public:
  explicit DenseMapperProcess(Bus& bus);

 private:
  void on_camera_model(const camera_model_t& message);
  void on_robot_model(const robot_model_t& message);
  void on_keyframe_image(const keyframe_image_t& message);
  void on_graph(const graph_t& message);
  void on_command(const command_t& message);
  void start_when_ready();
  void reset();
  void add_keyframe(const keyframe_image_t& message);
  bool take_graph(const graph_t& message);
  void integrate_and_publish();
  void publish_level(const LevelWish& wish);

  Bus& bus_;
  ResetGate reset_{"dense_mapper"};
  TilePublisher octomap_out_;
  TilePublisher cloud_out_;
  TilePublisher grid_out_;
  std::optional<CameraModel> camera_;
  std::optional<RobotModel> robot_;
  std::unique_ptr<DenseMapper> mapper_;        // made when both models are known
  std::deque<keyframe_image_t> early_images_;  // came before them
  std::vector<graph_t> early_graph_;
  std::map<std::int64_t, SE3> moved_;  // keyframes, by the parts of a GRAPH that have come
  bool complete_graph_ = false;        // has come: poses for an earlier process's images
  bool finished_ = false;              // after COMMAND finish each input is answered at once
  bool begins_anew_ = false;           // after COMMAND reset, until the new graph's first keyframe
};

}  // namespace fusion_slam
