#include "services/pose_graph/graph_messages.hpp"

#include <algorithm>
#include <cmath>

#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

// What KEYFRAME and LIDAR_NODE have in common.
template <class Message>
std::optional<NodeInput> common_part(NodeKind kind, const Message& message) {
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

bool is_node_kind(std::int8_t kind) {
  return kind == graph_node_t::KEYFRAME || kind == graph_node_t::LIDAR;
}

std::optional<NodeInput> node_from(const keyframe_t& message) {
  auto node = common_part(NodeKind::kKeyframe, message);
  if (!node) return std::nullopt;
  for (std::int32_t i = 0; i < message.n_refined; ++i)
    if (const auto T = from_message(message.T_previous_refined[static_cast<std::size_t>(i)]))
      node->refined.push_back({message.refined_id[static_cast<std::size_t>(i)], *T});
  for (std::int32_t f = 0; f < message.n; ++f) {
    const auto i = static_cast<std::size_t>(f);
    const bool finite = std::isfinite(message.u_px[i]) && std::isfinite(message.v_px[i]) &&
                        std::isfinite(message.depth_m[i]) &&
                        std::isfinite(message.depth_sigma_m[i]);
    if (message.landmark_id[i] <= 0 || !finite) continue;
    node->seen.push_back({message.landmark_id[i], f, message.u_px[i], message.v_px[i],
                          message.depth_m[i], message.depth_sigma_m[i],
                          std::clamp<std::int8_t>(message.octave[i], 0, 16)});
  }
  return node;
}

std::optional<NodeInput> node_from(const lidar_node_t& message) {
  return common_part(NodeKind::kLidar, message);
}

PoseInput pose_from(NodeKind sensor, const pose_estimate_t& message) {
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
  if (T_odom_base && T_reference_base && is_node_kind(message.reference_kind) &&
      message.reference_id > 0) {
    pose.reference = NodeId{static_cast<NodeKind>(message.reference_kind), message.reference_id};
    pose.T_reference_base = *T_reference_base;
  }
  return pose;
}

std::optional<LoopInput> loop_from(const constraint_t& message) {
  const auto T_from_to = from_message(message.T_from_to);
  if (!T_from_to || !is_node_kind(message.from_kind) || !is_node_kind(message.to_kind))
    return std::nullopt;
  LoopInput loop;
  loop.from = {static_cast<NodeKind>(message.from_kind), message.from_id};
  loop.to = {static_cast<NodeKind>(message.to_kind), message.to_id};
  loop.T_from_to = *T_from_to;
  loop.covariance = covariance_from_message(message.covariance);
  for (std::int32_t i = 0; i < message.n_same; ++i)
    loop.same_features.emplace_back(message.from_feature[static_cast<std::size_t>(i)],
                                    message.to_feature[static_cast<std::size_t>(i)]);
  return loop;
}

graph_node_t to_message(const NodeId& id, const GraphNode& node) {
  graph_node_t message{};
  message.kind = static_cast<std::int8_t>(id.kind);
  message.id = id.id;
  message.utime = node.utime_us;
  message.T_map_base = to_message(node.T_map_base, node.utime_us);
  return message;
}

pose_estimate_t to_message(const PoseOutput& pose) {
  pose_estimate_t message{};
  message.utime = pose.utime_us;
  message.frame = "map";
  message.T_frame_base = to_message(pose.T_map_base, pose.utime_us);
  to_message(pose.covariance, message.covariance);
  message.state = static_cast<std::int8_t>(pose.state);
  message.reason = pose.reason;
  message.reference_kind = static_cast<std::int8_t>(pose.reference.kind);
  message.reference_id = pose.reference.id;
  message.T_reference_base = to_message(pose.T_reference_base, pose.utime_us);
  message.fix_utime = pose.fix_utime_us;
  message.n_matched = pose.n_matched;
  return message;
}

loop_state_t to_message(const LoopState& loop) {
  loop_state_t message{};
  message.from_kind = static_cast<std::int8_t>(loop.from.kind);
  message.from_id = loop.from.id;
  message.to_kind = static_cast<std::int8_t>(loop.to.kind);
  message.to_id = loop.to.id;
  message.squared_error = loop.squared_error;
  message.reason = loop.reason;
  return message;
}

LoopState state_from(const loop_state_t& message) {
  return {{static_cast<NodeKind>(message.from_kind), message.from_id},
          {static_cast<NodeKind>(message.to_kind), message.to_id},
          message.squared_error,
          message.reason};
}

constraint_t to_message(const Retirement& retirement, std::int64_t utime_us,
                        std::int64_t n_placed) {
  constraint_t message{};
  message.utime = utime_us;
  message.seq = n_placed;
  message.from_kind = static_cast<std::int8_t>(retirement.carrier.kind);
  message.from_id = retirement.carrier.id;
  message.to_kind = static_cast<std::int8_t>(retirement.id.kind);
  message.to_id = retirement.id.id;
  message.T_from_to = to_message(retirement.T_carrier_base, utime_us);
  to_message(retirement.covariance, message.covariance);
  message.source = "pose_graph";
  return message;
}

std::optional<Retirement> retirement_from(const constraint_t& message) {
  const auto loop = loop_from(message);
  if (!loop) return std::nullopt;
  return Retirement{loop->to, loop->from, loop->T_from_to, loop->covariance};
}

}  // namespace fusion_slam
