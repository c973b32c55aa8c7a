#include "viz/web/viewer_process.hpp"

#include "viz/web/loop_history.hpp"

namespace fusion_slam {
namespace {

constexpr int kTick_ms = 500;

}  // namespace

template <class Message>
void ViewerProcess::show(const std::string& channel, Policy policy) {
  bus_.subscribe<Message>(channel, policy,
                          [this, channel](const Message& message) { state_.on(channel, message); });
}

template <class Message>
void ViewerProcess::hear(const std::string& channel) {
  bus_.listen<Message>(
      channel, [&state = state_, channel](const Message& message) { state.on(channel, message); });
}

ViewerProcess::ViewerProcess(Bus& bus, ViewerState& state) : bus_(bus), state_(state) {
  show<bot_core::pose_t>("GROUND_TRUTH", Policy::kKeepAll);
  show<camera_model_t>("CAMERA_MODEL", Policy::kLatestOnly);
  show<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly);
  show<pose_estimate_t>("VISUAL_POSE", Policy::kKeepAll);
  show<pose_estimate_t>("LIDAR_POSE", Policy::kKeepAll);
  show<pose_estimate_t>("POSE", Policy::kKeepAll);
  show<pose_estimate_t>("LOCALIZATION", Policy::kKeepAll);
  show<keyframe_t>("KEYFRAME", Policy::kKeepAll);
  show<lidar_node_t>("LIDAR_NODE", Policy::kKeepAll);
  show<graph_t>("GRAPH", Policy::kKeepAll);
  show<loop_candidate_t>("LOOP_CANDIDATE", Policy::kKeepAll);
  show<constraint_t>("CONSTRAINT", Policy::kKeepAll);
  show<command_t>("COMMAND", Policy::kKeepAll);
  bus.listen<status_t>("STATUS", [&bus, history = std::make_shared<LoopHistory>()](
                                     const status_t& status) { history->hear(status, bus); });
  // Not out of a queue: what is shown once and never asked for again, so that rates are those of
  // the network, and health, which has to be seen when everything else is stuck.
  hear<bot_core::images_t>("CAMERA");
  hear<bot_core::planar_lidar_t>("LIDAR");
  hear<bot_core::pose_t>("ODOMETRY");
  hear<keyframe_image_t>("KEYFRAME_IMAGE");
  hear<status_t>("STATUS");
  hear<procman_lcm::deputy_info_t>("PM_INFO");
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
