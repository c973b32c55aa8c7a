#include "services/loop_detector/loop_detector_process.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/loop_candidate_t.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kMaxEarly = 100;  // keyframes that wait for the models
constexpr int kMaxOctave = 31;

}  // namespace

std::optional<LoopKeyframe> from_message(const keyframe_t& message, std::string* why) {
  if (message.n < 0 || message.n_descriptor_bytes != message.n * std::int64_t{kDescriptorBytes}) {
    *why = "number of descriptor bytes is not 32 times the number of features";
    return std::nullopt;
  }
  LoopKeyframe keyframe;
  keyframe.id = message.id;
  keyframe.utime_us = message.utime;
  const std::optional<SE3> T_odom_base = from_message(message.T_odom_base);
  if (!T_odom_base) {
    *why = "T_odom_base is not a rigid motion";
    return std::nullopt;
  }
  keyframe.T_odom_base = *T_odom_base;
  for (std::int32_t i = 0; i < message.n; ++i) {
    const Feature f{message.u_px[i], message.v_px[i], message.depth_m[i], message.angle_rad[i],
                    message.octave[i]};
    const bool finite = std::isfinite(f.u_px) && std::isfinite(f.v_px) &&
                        std::isfinite(f.depth_m) && std::isfinite(f.angle_rad);
    if (!finite || f.octave < 0 || f.octave > kMaxOctave) {
      *why = "feature " + std::to_string(i) + " has an impossible position, angle or octave";
      return std::nullopt;
    }
    keyframe.features.features.push_back(f);
    keyframe.features.descriptors.push_back(
        descriptor_from_bytes(message.descriptors.data() + i * kDescriptorBytes));
  }
  return keyframe;
}

LoopDetectorProcess::LoopDetectorProcess(Bus& bus, LoopDetectorConfig config)
    : bus_(bus), config_(config) {
  bus_.subscribe<camera_model_t>("CAMERA_MODEL", Policy::kLatestOnly,
                                 [this](const camera_model_t& m) { on_camera_model(m); });
  bus_.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly,
                                [this](const robot_model_t& m) { on_robot_model(m); });
  bus_.subscribe<keyframe_t>("KEYFRAME", Policy::kKeepAll,
                             [this](const keyframe_t& m) { on_keyframe(m); });
  bus_.subscribe<graph_t>("GRAPH", Policy::kKeepAll, [this](const graph_t& m) { on_graph(m); });
  bus_.set_state_text("waiting for CAMERA_MODEL, ROBOT_MODEL and KEYFRAME");
}

void LoopDetectorProcess::on_camera_model(const camera_model_t& message) {
  if (camera_) return;
  std::string why;
  camera_ = from_message(message, &why);
  if (!camera_) bus_.report_error("CAMERA_MODEL refused: " + why);
  start_when_ready();
}

void LoopDetectorProcess::on_robot_model(const robot_model_t& message) {
  if (T_base_camera_) return;
  std::string why;
  const std::optional<RobotModel> robot = from_message(message, &why);
  if (!robot) return bus_.report_error("ROBOT_MODEL refused: " + why);
  T_base_camera_ = robot->T_base_camera;
  start_when_ready();
}

void LoopDetectorProcess::start_when_ready() {
  if (detector_ || !camera_ || !T_base_camera_) return;
  detector_ = std::make_unique<LoopDetector>(*camera_, *T_base_camera_, config_);
  for (LoopKeyframe& keyframe : early_) detect(std::move(keyframe));
  early_.clear();
}

void LoopDetectorProcess::on_keyframe(const keyframe_t& message) {
  std::string why;
  std::optional<LoopKeyframe> keyframe = from_message(message, &why);
  if (!keyframe) return bus_.report_error("KEYFRAME refused: " + why);
  if (detector_) return detect(std::move(*keyframe));
  if (early_.size() >= kMaxEarly)
    return bus_.report_error("KEYFRAME dropped: no CAMERA_MODEL or ROBOT_MODEL yet");
  early_.push_back(std::move(*keyframe));
}

void LoopDetectorProcess::on_graph(const graph_t& message) {
  if (!detector_) return;
  for (const graph_node_t& node : message.nodes)
    if (node.kind == graph_node_t::KEYFRAME)
      if (const std::optional<SE3> T_map_base = from_message(node.T_map_base))
        detector_->moved(node.id, *T_map_base);
}

void LoopDetectorProcess::detect(LoopKeyframe keyframe) {
  for (const LoopCandidate& candidate : detector_->add(std::move(keyframe))) {
    ++n_candidates_;
    publish_candidate(candidate);
    if (!candidate.accepted) continue;
    ++n_accepted_;
    publish_constraint(candidate);
  }
  bus_.set_state_text(std::to_string(detector_->n_keyframes()) + " keyframes, " +
                      std::to_string(n_candidates_) + " candidates, " +
                      std::to_string(n_accepted_) + " accepted");
}

void LoopDetectorProcess::publish_candidate(const LoopCandidate& candidate) {
  loop_candidate_t message{};
  message.utime = candidate.utime_us;
  message.from_kind = message.to_kind = graph_node_t::KEYFRAME;
  message.from_id = candidate.from_id;
  message.to_id = candidate.to_id;
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
  bus_.publish("LOOP_CANDIDATE", std::move(message));
}

void LoopDetectorProcess::publish_constraint(const LoopCandidate& candidate) {
  constraint_t message{};
  message.utime = candidate.utime_us;
  message.from_kind = message.to_kind = graph_node_t::KEYFRAME;
  message.from_id = candidate.from_id;
  message.to_id = candidate.to_id;
  message.T_from_to = to_message(candidate.T_from_to, candidate.utime_us);
  to_message(candidate.covariance, message.covariance);
  message.source = "visual loop";
  bus_.publish("CONSTRAINT", std::move(message));
}

}  // namespace fusion_slam
