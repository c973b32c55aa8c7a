#include "services/loop_detector/loop_messages.hpp"

#include <utility>

#include "libs/messages/convert.hpp"
#include "libs/place_messages/place_messages.hpp"

namespace fusion_slam {
namespace {

template <class Message, class Node>
bool common_part(const Message& message, Node* node, std::string* why) {
  node->id = message.id;
  node->seq = message.seq;
  node->utime_us = message.utime;
  node->previous_id = message.previous_id;
  const std::optional<SE3> T_odom_base = from_message(message.T_odom_base);
  const std::optional<SE3> T_previous_base = from_message(message.T_previous_base);
  if (!T_odom_base || (!T_previous_base && message.previous_id != 0)) {
    *why =
        T_odom_base ? "T_previous_base is not a rigid motion" : "T_odom_base is not a rigid motion";
    return false;
  }
  node->T_odom_base = *T_odom_base;
  if (T_previous_base) node->T_previous_base = *T_previous_base;
  node->covariance = covariance_from_message(message.covariance);
  return true;
}

}  // namespace

NodeKind kind_of(std::int8_t kind) {
  return kind == graph_node_t::LIDAR ? NodeKind::kLidar : NodeKind::kKeyframe;
}

std::optional<LoopMeasurement> from_message(const constraint_t& message) {
  const std::optional<SE3> T_from_to = from_message(message.T_from_to);
  if (!T_from_to) return std::nullopt;
  return LoopMeasurement{{kind_of(message.from_kind), message.from_id},
                         {kind_of(message.to_kind), message.to_id},
                         *T_from_to,
                         covariance_from_message(message.covariance),
                         {},
                         "earlier loop"};
}

std::optional<LoopKeyframe> from_message(const keyframe_t& message, std::string* why) {
  LoopKeyframe keyframe;
  if (!common_part(message, &keyframe, why)) return std::nullopt;
  auto features = features_from(message, why);
  if (!features) return std::nullopt;
  keyframe.features = std::move(*features);
  return keyframe;
}

std::optional<LoopScan> from_message(const lidar_node_t& message, std::string* why) {
  LoopScan scan;
  if (!common_part(message, &scan, why)) return std::nullopt;
  for (std::int32_t i = 0; i < message.n_submaps; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto T_submap_base = from_message(message.T_submap_base[k]);
    if (!T_submap_base) {
      *why = "T_submap_base is not a rigid motion";
      return std::nullopt;
    }
    scan.submaps.push_back({message.submap_ids[k], *T_submap_base});
  }
  auto points = points_from(message, why);
  if (!points) return std::nullopt;
  scan.points_base = std::move(*points);
  return scan;
}

loop_candidate_t to_message(const LoopCandidate& candidate) {
  loop_candidate_t message{};
  message.utime = candidate.utime_us;
  message.from_kind = static_cast<std::int8_t>(candidate.from.kind);
  message.to_kind = static_cast<std::int8_t>(candidate.to.kind);
  message.from_id = candidate.from.id;
  message.to_id = candidate.to.id;
  message.accepted = static_cast<std::int8_t>(candidate.accepted);
  for (const StageVerdict& verdict : candidate.stages) {
    stage_verdict_t stage{};
    stage.stage = verdict.stage;
    stage.score = verdict.score;
    stage.threshold = verdict.threshold;
    stage.passed = static_cast<std::int8_t>(verdict.passed);
    stage.reason = verdict.reason;
    message.stages.push_back(stage);
  }
  message.n_stages = static_cast<std::int32_t>(message.stages.size());
  return message;
}

constraint_t to_message(const LoopMeasurement& loop, std::int64_t utime_us) {
  constraint_t message{};
  message.utime = utime_us;
  message.from_kind = static_cast<std::int8_t>(loop.from.kind);
  message.from_id = loop.from.id;
  message.to_kind = static_cast<std::int8_t>(loop.to.kind);
  message.to_id = loop.to.id;
  message.T_from_to = to_message(loop.T_from_to, utime_us);
  to_message(loop.covariance, message.covariance);
  message.source = loop.by;
  for (const auto& [from, to] : loop.same_features) {
    message.from_feature.push_back(from);
    message.to_feature.push_back(to);
  }
  message.n_same = static_cast<std::int32_t>(message.from_feature.size());
  return message;
}

graph_t note_of(const std::vector<NodeId>& keyframes) {
  graph_t note{};
  for (const NodeId& id : keyframes) {
    graph_node_t node{};
    node.kind = graph_node_t::KEYFRAME;
    node.id = id.id;
    note.nodes.push_back(node);
  }
  note.n_nodes = static_cast<std::int32_t>(note.nodes.size());
  return note;
}

void take_note(const graph_t& note, std::vector<NodeId>* keyframes) {
  for (const graph_node_t& node : note.nodes) keyframes->push_back({NodeKind::kKeyframe, node.id});
}

}  // namespace fusion_slam
