// The dense mapper on the bus: KEYFRAME_IMAGE, GRAPH, CAMERA_MODEL, ROBOT_MODEL, COMMAND in; CLOUD,
// OCTOMAP, GRID_VISUAL, LEVEL out.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/journal_note_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/reset_gate.hpp"
#include "libs/bus/tile_channel.hpp"
#include "services/dense_mapper/dense_mapper.hpp"
#include "services/dense_mapper/pace.hpp"

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
  void take_image(const keyframe_image_t& message);
  void add_keyframe(const keyframe_image_t& message);
  void map_or_leave_out(const keyframe_image_t& message);
  void leave_out(std::int64_t id);
  void integrate();
  void publish_maps();
  std::size_t queue() const;  // messages that wait, live; else 0
  bool take_graph(const graph_t& message);
  void integrate_and_publish();
  void publish_level(const LevelWish& wish);

  // dense_mapper_journal.cpp
  void keep_journal();
  void on_saved(const journal_note_t& message);
  void go_on_where_it_ended();
  void write_down();      // what has changed
  void write_all_down();  // what a restart needs, instead of all that was written before
  void note(std::uint8_t flags, const SavedBytes& bytes);
  std::set<std::int64_t> needed_numbers(const std::string& channel);

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
  std::map<std::int64_t, keyframe_image_t> pending_;  // by id: wait for poses, still compressed
  std::map<std::int64_t, SE3> moved_;  // keyframes, by the parts of a GRAPH that have come
  bool complete_graph_ = false;        // has come: poses for an earlier process's images
  bool finished_ = false;              // after COMMAND finish each input is answered at once
  Pace pace_;
  std::int64_t left_out_ = 0;  // images, because it was behind
  bool begins_anew_ = false;   // after COMMAND reset, until the new graph's first keyframe

  // By the journal of an earlier process, until the mapper is made.
  std::optional<SavedMap> saved_;
  bool saved_is_whole_ = false;
  bool went_on_ = false;                         // the mapper began with it
  bool all_is_due_ = true;                       // nothing of this map is in the journal yet
  std::int64_t commands_upto_us_ = 0;            // utime of the newest command obeyed
  std::map<std::int64_t, std::int64_t> number_;  // of KEYFRAME_IMAGE, by keyframe
};

}  // namespace fusion_slam
