#include "services/pose_graph/pose_graph_process.hpp"

#include <algorithm>
#include <string>

#include "fusion_slam/graph_t.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kNodesPerPart = 400;          // 400 * 81 bytes: one datagram
constexpr std::int64_t kRevisionsPerComplete = 50;  // a listener that lost a message is whole again
constexpr int kCompletePeriodMs = 1000;             // live: and one that started late, too

graph_node_t to_message(const NodeId& id, const GraphNode& node) {
  graph_node_t message{};
  message.kind = static_cast<std::int8_t>(id.kind);
  message.id = id.id;
  message.utime = node.utime_us;
  message.T_map_base = fusion_slam::to_message(node.T_map_base, node.utime_us);
  return message;
}

bool is_kind(std::int8_t kind) {
  return kind == graph_node_t::KEYFRAME || kind == graph_node_t::LIDAR;
}

// What KEYFRAME and LIDAR_NODE have in common.
template <class Message>
std::optional<NodeInput> node_from(NodeKind kind, const Message& message) {
  const auto T_odom_base = from_message(message.T_odom_base);
  const auto T_previous_base = from_message(message.T_previous_base);
  if (!T_odom_base) return std::nullopt;
  if (!T_previous_base && message.previous_id != 0) return std::nullopt;
  NodeInput node;
  node.id = {kind, message.id};
  node.utime_us = message.utime;
  node.T_odom_base = *T_odom_base;
  node.previous_id = message.previous_id;
  if (T_previous_base) node.T_previous_base = *T_previous_base;
  node.covariance = covariance_from_message(message.covariance);
  return node;
}

}  // namespace

PoseGraphProcess::PoseGraphProcess(Bus& bus) : bus_(bus) {
  const auto on = [this](auto method) {
    return [this, method](const auto& message) {
      (this->*method)(message);
      publish_news();
    };
  };
  bus.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly, on(&PoseGraphProcess::on_robot));
  bus.subscribe<keyframe_t>("KEYFRAME", Policy::kKeepAll, on(&PoseGraphProcess::on_keyframe));
  bus.subscribe<lidar_node_t>("LIDAR_NODE", Policy::kKeepAll, on(&PoseGraphProcess::on_lidar_node));
  bus.subscribe<constraint_t>("CONSTRAINT", Policy::kKeepAll, on(&PoseGraphProcess::on_constraint));
  bus.subscribe<constraint_t>("LEVEL", Policy::kKeepAll, on(&PoseGraphProcess::on_level));
  bus.subscribe<bot_core::pose_t>("ODOMETRY", Policy::kKeepAll, on(&PoseGraphProcess::on_odometry));
  bus.subscribe<command_t>("COMMAND", Policy::kKeepAll, on(&PoseGraphProcess::on_command));
  const auto on_pose_of = [this](NodeKind sensor) {
    return [this, sensor](const pose_estimate_t& message) {
      on_pose(sensor, message);
      publish_news();
    };
  };
  bus.subscribe<pose_estimate_t>("VISUAL_POSE", Policy::kKeepAll, on_pose_of(NodeKind::kKeyframe));
  bus.subscribe<pose_estimate_t>("LIDAR_POSE", Policy::kKeepAll, on_pose_of(NodeKind::kLidar));
  if (bus.mode() == Mode::kLive) bus.every(kCompletePeriodMs, [this] { publish_complete(); });
}

void PoseGraphProcess::on_robot(const robot_model_t& message) {
  std::string why;
  if (const auto robot = from_message(message, &why))
    graph_.set_robot(*robot);
  else
    reject("ROBOT_MODEL", why.c_str());
}

void PoseGraphProcess::on_keyframe(const keyframe_t& message) {
  if (const auto node = node_from(NodeKind::kKeyframe, message))
    graph_.add_node(*node);
  else
    reject("KEYFRAME", "a pose is not a rigid motion");
}

void PoseGraphProcess::on_lidar_node(const lidar_node_t& message) {
  if (const auto node = node_from(NodeKind::kLidar, message))
    graph_.add_node(*node);
  else
    reject("LIDAR_NODE", "a pose is not a rigid motion");
}

void PoseGraphProcess::on_pose(NodeKind sensor, const pose_estimate_t& message) {
  const auto T_odom_base = from_message(message.T_frame_base);
  const auto T_reference_base = from_message(message.T_reference_base);
  PoseInput pose;
  pose.sensor = sensor;
  pose.utime_us = message.utime;
  pose.state = static_cast<PoseState>(std::clamp<int>(message.state, 0, 3));
  pose.reason = message.reason;
  pose.fix_utime_us = message.fix_utime;
  pose.n_matched = message.n_matched;
  pose.covariance = covariance_from_message(message.covariance);
  if (T_odom_base) pose.T_odom_base = *T_odom_base;
  if (T_odom_base && T_reference_base && is_kind(message.reference_kind) &&
      message.reference_id > 0) {
    pose.reference = NodeId{static_cast<NodeKind>(message.reference_kind), message.reference_id};
    pose.T_reference_base = *T_reference_base;
  }
  graph_.add_pose(pose);
}

void PoseGraphProcess::on_odometry(const bot_core::pose_t& message) {
  if (const auto T_odom_base = from_message(message))
    graph_.add_odometry(message.utime, *T_odom_base);
  else
    reject("ODOMETRY", "the pose is not a rigid motion");
}

void PoseGraphProcess::on_constraint(const constraint_t& message) {
  const auto T_from_to = from_message(message.T_from_to);
  if (!T_from_to || !is_kind(message.from_kind) || !is_kind(message.to_kind))
    return reject("CONSTRAINT", "the motion is not rigid or a node's kind does not exist");
  graph_.add_loop({static_cast<NodeKind>(message.from_kind), message.from_id},
                  {static_cast<NodeKind>(message.to_kind), message.to_id}, *T_from_to,
                  covariance_from_message(message.covariance));
}

// A prior on a node's z, roll and pitch. Its covariance says no more than that: the other three are
// free, so the smallest motion of the map satisfies it.
void PoseGraphProcess::on_level(const constraint_t& message) {
  const auto T_level_id = from_message(message.T_from_to);
  if (!T_level_id || message.from_kind != graph_node_t::MAP || !is_kind(message.to_kind))
    return reject("LEVEL", "the motion is not rigid, or not from the map to a node");
  std::string why;
  if (!graph_.level_map({static_cast<NodeKind>(message.to_kind), message.to_id}, *T_level_id, &why))
    reject("LEVEL", why.c_str());
}

void PoseGraphProcess::on_command(const command_t& message) {
  if (!message.target.empty() && message.target != "pose_graph") return;
  if (message.verb == "finish") {
    graph_.finish();
    publish_news();
    publish_complete();
  } else if (message.verb == "reset") {
    graph_ = PoseGraph();
    last_complete_ = 0;
    publish_complete();
  }
}

void PoseGraphProcess::publish_news() {
  std::vector<graph_node_t> changed;
  for (const auto& [id, node] : graph_.take_changes()) changed.push_back(to_message(id, node));
  if (!changed.empty()) {
    publish_graph(changed, false);
    if (graph_.revision() - last_complete_ >= kRevisionsPerComplete) publish_complete();
    say_state();
  }
  for (const PoseOutput& pose : graph_.take_poses()) publish_pose(pose);
}

void PoseGraphProcess::publish_complete() {
  std::vector<graph_node_t> all;
  for (const auto& [id, node] : graph_.nodes()) all.push_back(to_message(id, node));
  publish_graph(all, true);
  last_complete_ = graph_.revision();
}

void PoseGraphProcess::publish_graph(const std::vector<graph_node_t>& nodes, bool complete) {
  const std::size_t n_parts =
      std::max<std::size_t>(1, (nodes.size() + kNodesPerPart - 1) / kNodesPerPart);
  for (std::size_t part = 0; part < n_parts; ++part) {
    const auto begin = nodes.begin() + static_cast<std::ptrdiff_t>(part * kNodesPerPart);
    const auto end = nodes.begin() + static_cast<std::ptrdiff_t>(
                                         std::min(nodes.size(), (part + 1) * kNodesPerPart));
    graph_t message{};
    message.utime = graph_.newest_utime_us();
    message.revision = graph_.revision();
    message.complete = complete ? 1 : 0;
    message.part = static_cast<std::int32_t>(part);
    message.n_parts = static_cast<std::int32_t>(n_parts);
    message.nodes.assign(begin, end);
    message.n_nodes = static_cast<std::int32_t>(message.nodes.size());
    bus_.publish("GRAPH", message);
  }
}

void PoseGraphProcess::publish_pose(const PoseOutput& pose) {
  pose_estimate_t message{};
  message.utime = pose.utime_us;
  message.frame = "map";
  message.T_frame_base = fusion_slam::to_message(pose.T_map_base, pose.utime_us);
  fusion_slam::to_message(pose.covariance, message.covariance);
  message.state = static_cast<std::int8_t>(pose.state);
  message.reason = pose.reason;
  message.reference_kind = static_cast<std::int8_t>(pose.reference.kind);
  message.reference_id = pose.reference.id;
  message.T_reference_base = fusion_slam::to_message(pose.T_reference_base, pose.utime_us);
  message.fix_utime = pose.fix_utime_us;
  message.n_matched = pose.n_matched;
  bus_.publish("POSE", message);
}

void PoseGraphProcess::reject(const char* channel, const char* why) {
  bus_.report_error(std::string(channel) + ": " + why);
}

void PoseGraphProcess::say_state() {
  const PoseGraphCounts& n = graph_.counts();
  bus_.set_state_text(std::to_string(graph_.nodes().size()) + " nodes, " + std::to_string(n.loops) +
                      " loops (" + std::to_string(n.loops_outvoted) + " outvoted), " +
                      std::to_string(n.ties) + " camera-LiDAR ties, " + std::to_string(n.restarts) +
                      " restarts");
}

}  // namespace fusion_slam
