// Visual odometry on the bus: CAMERA, LIDAR, LIDAR_POSE and GRAPH in; VISUAL_POSE, KEYFRAME and
// KEYFRAME_IMAGE out.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "bot_core/images_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/command_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/journal_mark.hpp"
#include "libs/bus/reset_gate.hpp"
#include "services/visual_odometry/frames_ahead.hpp"
#include "services/visual_odometry/visual_odometry.hpp"

namespace fusion_slam {

// Starts tracking with the first frame after CAMERA_MODEL and ROBOT_MODEL; both are taken once:
// what they say later is not looked at until the process starts again. COMMAND reset starts a new
// segment.
class VisualOdometryProcess {
 public:
  explicit VisualOdometryProcess(Bus& bus, VisualOdometryConfig config = {});

 private:
  void on_camera_model(const camera_model_t& message);
  void on_robot_model(const robot_model_t& message);
  void on_lidar(const bot_core::planar_lidar_t& message);
  void on_lidar_pose(const pose_estimate_t& message);
  void on_graph(const graph_t& message);
  void on_camera(const bot_core::images_t& message);
  void on_command(const command_t& message);
  void on_earlier_keyframe(const keyframe_t& message);
  void publish_pose(const TrackingResult& result);
  void publish_keyframe(const Keyframe& keyframe, const bot_core::images_t& images);

  Bus& bus_;
  ResetGate reset_{"visual_odometry"};
  SourceIds ids_;  // of keyframes, by the journal
  VisualOdometryConfig config_;
  std::optional<CameraModel> camera_;
  std::optional<RobotModel> robot_;
  std::unique_ptr<VisualOdometry> odometry_;
  // Of a replay; filled with the first frame. Shared with the bus's listener, which may outlive
  // this object.
  struct Ahead {
    std::mutex mutex;
    std::shared_ptr<FramesAhead> frames;
  };
  std::shared_ptr<Ahead> ahead_ = std::make_shared<Ahead>();
  std::deque<Keyframe> earlier_;  // last keyframes of an earlier process, by the journal
};

}  // namespace fusion_slam
