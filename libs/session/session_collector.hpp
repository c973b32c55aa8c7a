// What a run leaves behind. Fed with the messages of a session, in the order they come, it writes
// the trajectory and the maps at any moment. Knows the message types but no bus. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bot_core/images_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "fusion_slam/status_t.hpp"
#include "fusion_slam/tile_t.hpp"
#include "libs/camera/camera_model.hpp"
#include "libs/robot/robot_model.hpp"
#include "libs/session/final_trajectory.hpp"
#include "libs/session/graph_state.hpp"
#include "libs/session/map_collection.hpp"

namespace fusion_slam {

struct MissingFile {
  std::string name;
  std::string reason;
};

struct SessionResult {
  std::vector<std::string> files;    // written, by name
  std::vector<MissingFile> missing;  // left out, and why
  std::string map_source;            // channel that map.pgm was made of; empty: no map
  std::size_t camera_frames = 0;
  std::size_t lidar_scans = 0;
  std::size_t trajectory_poses = 0;
  std::size_t bridged_poses = 0;  // camera lost, interpolated between scans
  double coverage_percent =
      0.0;  // trajectory poses of camera frames (of scans where there is no camera)
  std::size_t live_poses = 0;
  std::size_t live_lost = 0;  // POSE said LOST: not in live.tum
  std::size_t ground_truth_poses = 0;
  std::size_t graph_nodes = 0;
  std::int64_t graph_revision = 0;
  std::size_t cloud_points = 0;
  std::size_t damaged_tiles = 0;
  std::size_t damaged_messages = 0;  // poses that are none
  double path_length_m = 0.0;        // of the final trajectory
  double free_area_m2 = 0.0;         // of map.pgm
  double occupied_area_m2 = 0.0;
};

class SessionCollector {
 public:
  // The map began anew: what `before` knows of the robot, its camera and the processes stays true.
  void begin_like(const SessionCollector& before);

  void on_robot_model(const robot_model_t& message);
  void on_camera_model(const camera_model_t& message);
  void on_camera(std::int64_t utime_us);
  void on_camera(const bot_core::images_t& message) { on_camera(message.utime); }
  void on_lidar(std::int64_t utime_us);
  void on_lidar(const bot_core::planar_lidar_t& message) { on_lidar(message.utime); }
  void on_ground_truth(const bot_core::pose_t& message);
  void on_visual_pose(const pose_estimate_t& message);
  void on_lidar_pose(const pose_estimate_t& message);
  void on_pose(const pose_estimate_t& message);
  void on_graph(const graph_t& message);
  void on_tile(const std::string& channel, const Tile& tile);  // from a TileReceiver
  void on_tile(const std::string& channel, const tile_t& message);
  void on_status(const status_t& message);

  // Writes trajectory.tum, live.tum, groundtruth.tum, map.pgm, map.yaml, map.png,
  // lidar_map.pgm, lidar_map.yaml, visual_map.pgm, visual_map.yaml, octomap.bt, cloud.ply into a
  // directory (made when needed): each whole or not at all, what has no content is left out and
  // named in the result. May be called at any time and again. Throws std::runtime_error when the
  // directory or a file can't be written. Byte-identical for equal final state.
  SessionResult write(const std::filesystem::path& directory) const;

  const std::optional<RobotModel>& robot() const { return robot_; }
  const std::optional<CameraModel>& camera_model() const { return camera_model_; }
  // Newest STATUS of each process; a restarted process is another one.
  const std::map<std::pair<std::string, std::int32_t>, status_t>& statuses() const {
    return statuses_;
  }
  std::int64_t dropped_total() const;  // of all processes and channels
  std::int64_t lost_total() const;

 private:
  void on_tracked(const pose_estimate_t& message, std::map<std::int64_t, TrackedPose>* poses);

  std::optional<RobotModel> robot_;
  std::optional<CameraModel> camera_model_;
  TrackedSession tracked_;  // its nodes are filled in by write()
  GraphState graph_;
  MapCollection maps_;
  std::map<std::int64_t, SE3> live_;          // T_map_base as published
  std::map<std::int64_t, SE3> ground_truth_;  // of the reference frame
  std::size_t live_lost_ = 0;
  std::size_t damaged_messages_ = 0;
  std::map<std::pair<std::string, std::int32_t>, status_t> statuses_;
};

}  // namespace fusion_slam
