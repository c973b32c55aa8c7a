#include "services/loop_detector/loop_messages.hpp"

#include <cmath>

#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

constexpr int kMaxOctave = 31;

template <class Message, class Node>
bool common_part(const Message& message, Node* node, std::string* why) {
  node->id = message.id;
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

std::optional<LoopKeyframe> from_message(const keyframe_t& message, std::string* why) {
  if (message.n < 0 || message.n_descriptor_bytes != message.n * std::int64_t{kDescriptorBytes}) {
    *why = "number of descriptor bytes is not 32 times the number of features";
    return std::nullopt;
  }
  LoopKeyframe keyframe;
  if (!common_part(message, &keyframe, why)) return std::nullopt;
  for (std::int32_t i = 0; i < message.n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    Feature f;
    f.u_px = message.u_px[k];
    f.v_px = message.v_px[k];
    f.depth_m = message.depth_m[k];
    f.angle_rad = message.angle_rad[k];
    f.octave = message.octave[k];
    f.depth_sigma_m = message.depth_sigma_m[k];
    const bool finite = std::isfinite(f.u_px) && std::isfinite(f.v_px) &&
                        std::isfinite(f.depth_m) && std::isfinite(f.angle_rad);
    if (!finite || f.octave < 0 || f.octave > kMaxOctave) {
      *why = "feature " + std::to_string(i) + " has an impossible position, angle or octave";
      return std::nullopt;
    }
    keyframe.features.features.push_back(f);
    keyframe.features.descriptors.push_back(
        descriptor_from_bytes(message.descriptors.data() + k * kDescriptorBytes));
  }
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
  for (std::int32_t i = 0; i < message.n_points; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!std::isfinite(message.x_m[k]) || !std::isfinite(message.y_m[k])) {
      *why = "point " + std::to_string(i) + " is not finite";
      return std::nullopt;
    }
    scan.points_base.emplace_back(message.x_m[k], message.y_m[k]);
  }
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

}  // namespace fusion_slam
