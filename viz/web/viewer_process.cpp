#include "viz/web/viewer_process.hpp"

#include "fusion_slam/command_t.hpp"

namespace fusion_slam {
namespace {

constexpr int kTick_ms = 500;

}  // namespace

template <class Message>
void ViewerProcess::show(const std::string& channel, Policy policy) {
  bus_.subscribe<Message>(channel, policy,
                          [this, channel](const Message& message) { state_.on(channel, message); });
}

ViewerProcess::ViewerProcess(Bus& bus, ViewerState& state) : bus_(bus), state_(state) {
  show<bot_core::images_t>("CAMERA", Policy::kLatestOnly);
  show<bot_core::planar_lidar_t>("LIDAR", Policy::kLatestOnly);
  show<bot_core::pose_t>("ODOMETRY", Policy::kLatestOnly);
  show<bot_core::pose_t>("GROUND_TRUTH", Policy::kKeepAll);
  show<camera_model_t>("CAMERA_MODEL", Policy::kLatestOnly);
  show<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly);
  show<pose_estimate_t>("VISUAL_POSE", Policy::kKeepAll);
  show<pose_estimate_t>("LIDAR_POSE", Policy::kKeepAll);
  show<pose_estimate_t>("POSE", Policy::kKeepAll);
  show<keyframe_t>("KEYFRAME", Policy::kKeepAll);
  show<keyframe_image_t>("KEYFRAME_IMAGE", Policy::kLatestOnly);
  show<lidar_node_t>("LIDAR_NODE", Policy::kKeepAll);
  show<graph_t>("GRAPH", Policy::kKeepAll);
  show<loop_candidate_t>("LOOP_CANDIDATE", Policy::kKeepAll);
  show<constraint_t>("CONSTRAINT", Policy::kKeepAll);
  // Not one of a queue: health has to be shown when everything else is stuck.
  bus.listen<status_t>("STATUS", [this](const status_t& m) { state_.on("STATUS", m); });
  bus.listen<procman_lcm::deputy_info_t>(
      "PM_INFO", [this](const procman_lcm::deputy_info_t& m) { state_.on("PM_INFO", m); });
  for (const char* channel : {"GRID_FUSED", "GRID_LIDAR", "GRID_VISUAL", "OCTOMAP", "CLOUD"})
    tiles_.push_back(std::make_unique<TileReceiver>(
        bus, channel, [this, channel](const Tile& tile) { state_.on_tile(channel, tile); }));
  bus.every(kTick_ms, [this] { state_.tick(); });
}

void ViewerProcess::send(const std::string& target, const std::string& verb,
                         const std::string& argument) {
  command_t command{};
  command.utime = state_.session_utime_us();
  command.target = target;
  command.verb = verb;
  command.argument = argument;
  bus_.publish("COMMAND", command);
}

}  // namespace fusion_slam
