#include "services/loop_detector/loop_detector_process.hpp"

#include <string>
#include <utility>

#include "fusion_slam/graph_node_t.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kMaxEarly = 100;  // nodes of a kind that wait for the models

}  // namespace

LoopDetectorProcess::LoopDetectorProcess(Bus& bus, LoopDetectorConfig config)
    : bus_(bus), config_(std::move(config)), submap_tiles_(bus, "SUBMAP", [this](const Tile& tile) {
        if (detector_)
          detector_->add_tile(tile);
        else if (early_tiles_.size() < kMaxEarly)
          early_tiles_.push_back(tile);
      }) {
  bus_.subscribe<camera_model_t>("CAMERA_MODEL", Policy::kLatestOnly,
                                 [this](const camera_model_t& m) { on_camera_model(m); });
  bus_.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly,
                                [this](const robot_model_t& m) { on_robot_model(m); });
  bus_.subscribe<graph_t>("GRAPH", Policy::kKeepAll, [this](const graph_t& m) { on_graph(m); });
  bus_.subscribe<lidar_node_t>("LIDAR_NODE", Policy::kKeepAll,
                               [this](const lidar_node_t& m) { on_lidar_node(m); });
  bus_.subscribe<keyframe_t>("KEYFRAME", Policy::kKeepAll,
                             [this](const keyframe_t& m) { on_keyframe(m); });
  bus_.subscribe<command_t>("COMMAND", Policy::kKeepAll,
                            [this](const command_t& m) { on_command(m); });
  keep_journal();
  bus_.set_state_text("waiting for ROBOT_MODEL");
}

void LoopDetectorProcess::take(const LoopKeyframe& keyframe) {
  if (bus_.recovering()) return detector_->remember(keyframe);
  publish(detector_->add(keyframe));
  write_down_now_and_then();
}

void LoopDetectorProcess::take(const LoopScan& scan) {
  if (bus_.recovering()) return detector_->remember(scan);
  publish(detector_->add(scan));
}

void LoopDetectorProcess::on_camera_model(const camera_model_t& message) {
  if (camera_) return;
  std::string why;
  camera_ = from_message(message, &why);
  if (!camera_) bus_.report_error("CAMERA_MODEL refused: " + why);
  start_when_ready();
}

void LoopDetectorProcess::on_robot_model(const robot_model_t& message) {
  if (robot_) return;
  std::string why;
  robot_ = from_message(message, &why);
  if (!robot_) return bus_.report_error("ROBOT_MODEL refused: " + why);
  start_when_ready();
}

void LoopDetectorProcess::start_when_ready() {
  if (!robot_) return;
  if (!detector_) {
    detector_ = std::make_unique<LoopDetector>(*robot_, config_);
    go_on_where_it_ended();
    for (const Tile& tile : std::exchange(early_tiles_, {})) detector_->add_tile(tile);
    for (const LoopScan& scan : std::exchange(early_scans_, {})) take(scan);
  }
  if (!camera_) return;
  detector_->set_camera(*camera_);
  for (const LoopKeyframe& keyframe : std::exchange(early_keyframes_, {})) take(keyframe);
}

void LoopDetectorProcess::on_keyframe(const keyframe_t& message) {
  std::string why;
  std::optional<LoopKeyframe> keyframe = from_message(message, &why);
  if (!keyframe) return bus_.report_error("KEYFRAME refused: " + why);
  if (!reset_.passes(message.utime)) return;
  if (detector_ && camera_) return take(*keyframe);
  if (early_keyframes_.size() >= kMaxEarly)
    return bus_.report_error("KEYFRAME dropped: no CAMERA_MODEL or ROBOT_MODEL yet");
  early_keyframes_.push_back(std::move(*keyframe));
}

void LoopDetectorProcess::on_lidar_node(const lidar_node_t& message) {
  std::string why;
  std::optional<LoopScan> scan = from_message(message, &why);
  if (!scan) return bus_.report_error("LIDAR_NODE refused: " + why);
  if (!reset_.passes(message.utime)) return;
  if (detector_) return take(*scan);
  if (early_scans_.size() >= kMaxEarly)
    return bus_.report_error("LIDAR_NODE dropped: no ROBOT_MODEL yet");
  early_scans_.push_back(std::move(*scan));
}

void LoopDetectorProcess::on_graph(const graph_t& message) {
  if (!detector_) return;
  for (const graph_node_t& node : message.nodes)
    if (reset_.passes(node.utime) &&
        (node.kind == graph_node_t::KEYFRAME || node.kind == graph_node_t::LIDAR))
      if (const std::optional<SE3> T_map_base = from_message(node.T_map_base))
        detector_->moved({kind_of(node.kind), node.id}, *T_map_base);
  for (const loop_state_t& loop : message.switched_off) {
    const NodeId from{kind_of(loop.from_kind), loop.from_id};
    const NodeId to{kind_of(loop.to_kind), loop.to_id};
    if (known_off_.emplace(from, to).second) detector_->switched_off(from, to);
  }
}

void LoopDetectorProcess::on_command(const command_t& message) {
  if (reset_.asks(message)) {
    early_keyframes_.clear();
    early_scans_.clear();
    early_tiles_.clear();
    known_off_.clear();
    if (bus_.mode() == Mode::kLive) bus_.forget_sent("LOOP_CANDIDATE");
    if (!detector_) return;
    detector_ = std::make_unique<LoopDetector>(*robot_, config_);
    if (camera_) detector_->set_camera(*camera_);
    if (!bus_.recovering()) write_down();  // what was noted of the old map is void
    return say_state();
  }
  const bool for_us = message.target.empty() || message.target == "loop_detector";
  if (for_us && message.verb == "finish" && detector_) publish(detector_->finish());
}

void LoopDetectorProcess::publish(const std::vector<LoopCandidate>& decided) {
  for (const LoopCandidate& candidate : decided) {
    bus_.publish("LOOP_CANDIDATE", to_message(candidate));
    if (!candidate.accepted) continue;
    for (const LoopMeasurement& loop : candidate.measurements)
      bus_.publish("CONSTRAINT", to_message(loop, candidate.utime_us));
  }
  note_news();
  say_state();
}

void LoopDetectorProcess::say_state() {
  const LoopCounts& c = detector_->counts();
  bus_.set_state_text(std::to_string(c.keyframes) + " keyframes, " + std::to_string(c.scans) +
                      " scans, " + std::to_string(c.lidar_searches) + " LiDAR searches, " +
                      std::to_string(c.candidates) + " candidates, " + std::to_string(c.accepted) +
                      " accepted; " + std::to_string(c.retired) +
                      " keyframes of places seen often left out, " + std::to_string(c.nothing_new) +
                      " closures there spared");
}

}  // namespace fusion_slam
