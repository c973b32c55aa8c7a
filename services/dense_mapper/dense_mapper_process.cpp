#include "services/dense_mapper/dense_mapper_process.hpp"

#include <string>

#include "fusion_slam/constraint_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kMaxEarlyImages = 64;  // models come at 1 Hz, keyframes at a few Hz

}  // namespace

DenseMapperProcess::DenseMapperProcess(Bus& bus)
    : bus_(bus),
      octomap_out_(bus, "OCTOMAP"),
      cloud_out_(bus, "CLOUD"),
      grid_out_(bus, "GRID_VISUAL") {
  bus.subscribe<camera_model_t>("CAMERA_MODEL", Policy::kLatestOnly,
                                [this](const camera_model_t& m) { on_camera_model(m); });
  bus.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly,
                               [this](const robot_model_t& m) { on_robot_model(m); });
  bus.subscribe<keyframe_image_t>("KEYFRAME_IMAGE", Policy::kKeepAll,
                                  [this](const keyframe_image_t& m) { on_keyframe_image(m); });
  bus.subscribe<graph_t>("GRAPH", Policy::kKeepAll, [this](const graph_t& m) { on_graph(m); });
  bus.subscribe<command_t>("COMMAND", Policy::kKeepAll,
                           [this](const command_t& m) { on_command(m); });
  bus.never_await({"KEYFRAME_IMAGE", "GRAPH", "COMMAND"});  // the order does not matter
  // An earlier process's images are mapped again at once where the graph has their keyframes now:
  // so the journal is read when the graph is known, and none waits in memory for its pose.
  bus.keep_in_journal({"KEYFRAME_IMAGE", "COMMAND"}, Bus::Recover::kWhenAsked);
  bus.keep_in_journal({"CAMERA_MODEL", "ROBOT_MODEL"});
  bus.keep_said<constraint_t>("LEVEL", [](const constraint_t&) {});
  bus.set_state_text("waiting for CAMERA_MODEL and ROBOT_MODEL");
}

void DenseMapperProcess::on_camera_model(const camera_model_t& message) {
  if (camera_) return;  // a session has one camera
  std::string why;
  camera_ = from_message(message, &why);
  if (!camera_) bus_.report_error("CAMERA_MODEL: " + why);
  start_when_ready();
}

void DenseMapperProcess::on_robot_model(const robot_model_t& message) {
  if (robot_) return;
  std::string why;
  robot_ = from_message(message, &why);
  if (!robot_) bus_.report_error("ROBOT_MODEL: " + why);
  start_when_ready();
}

void DenseMapperProcess::start_when_ready() {
  if (mapper_ || !camera_ || !robot_) return;
  mapper_ = std::make_unique<DenseMapper>(*camera_, *robot_, DenseMapperConfig{});
  for (const graph_t& graph : early_graph_) take_graph(graph);
  for (const keyframe_image_t& image : early_images_) add_keyframe(image);
  early_graph_.clear();
  early_images_.clear();
  if (complete_graph_) bus_.recover();
  integrate_and_publish();
}

void DenseMapperProcess::on_keyframe_image(const keyframe_image_t& message) {
  if (!mapper_) {
    early_images_.push_back(message);
    if (early_images_.size() > kMaxEarlyImages) {
      early_images_.pop_front();
      bus_.report_error(
          "KEYFRAME_IMAGE: no CAMERA_MODEL and ROBOT_MODEL yet, oldest image dropped");
    }
    return;
  }
  add_keyframe(message);
  if (bus_.recovering())
    mapper_->integrate_ready();
  else
    integrate_and_publish();
}

void DenseMapperProcess::add_keyframe(const keyframe_image_t& message) {
  if (!reset_.passes(message.utime)) return;
  std::string why;
  const auto frame = from_message(message.images, &why);
  if (!frame) {
    bus_.report_error("KEYFRAME_IMAGE " + std::to_string(message.id) + ": " + why);
    return;
  }
  if (!mapper_->add_keyframe(message.id, *frame))
    bus_.report_error("KEYFRAME_IMAGE " + std::to_string(message.id) +
                      ": not the size CAMERA_MODEL says, or an id that came before");
}

void DenseMapperProcess::on_graph(const graph_t& message) {
  if (!mapper_) {
    early_graph_.push_back(message);
    return;
  }
  if (!take_graph(message)) return;
  if (complete_graph_) bus_.recover();
  integrate_and_publish();
}

// All parts at once: a keyframe must not be placed by a pose from before the map moved and an
// anchor from after. False: more parts come.
bool DenseMapperProcess::take_graph(const graph_t& message) {
  for (const graph_node_t& node : message.nodes) {
    if (node.kind != graph_node_t::KEYFRAME || !reset_.passes(node.utime)) continue;
    if (const auto T_map_base = from_message(node.T_map_base))
      moved_[node.id] = *T_map_base;
    else
      bus_.report_error("GRAPH: pose of keyframe " + std::to_string(node.id) + " is not a pose");
  }
  if (message.part + 1 < message.n_parts) return false;
  if (begins_anew_ && !moved_.empty()) {
    mapper_->begin_at(moved_.begin()->first);
    begins_anew_ = false;
  }
  for (const auto& [id, T_map_base] : moved_) mapper_->set_pose(id, T_map_base, message.utime);
  moved_.clear();
  complete_graph_ = complete_graph_ || (message.complete != 0 && !message.nodes.empty());
  return true;
}

void DenseMapperProcess::on_command(const command_t& message) {
  if (reset_.asks(message)) return reset();
  if (message.verb != "finish") return;
  if (!message.target.empty() && message.target != "dense_mapper") return;
  finished_ = true;
  if (mapper_) integrate_and_publish();
}

void DenseMapperProcess::reset() {
  early_images_.clear();
  early_graph_.clear();
  moved_.clear();
  finished_ = false;
  begins_anew_ = true;
  for (TilePublisher* out : {&octomap_out_, &cloud_out_, &grid_out_}) out->clear();
  if (!mapper_) return;
  mapper_ = std::make_unique<DenseMapper>(*camera_, *robot_, DenseMapperConfig{});
  integrate_and_publish();
}

void DenseMapperProcess::integrate_and_publish() {
  mapper_->integrate_ready();
  if (finished_ || mapper_->due()) {
    if (const auto wish = mapper_->wish_level(finished_)) publish_level(*wish);
    // The raster first: the fused map waits for it.
    for (const Tile& tile : mapper_->update_grid(finished_).grid) grid_out_.publish(tile);
    const DenseTiles maps = mapper_->update_maps();
    for (const Tile& tile : maps.octomap) octomap_out_.publish(tile);
    for (const Tile& tile : maps.cloud) cloud_out_.publish(tile);
  }
  bus_.set_state_text(std::to_string(mapper_->integrated()) + " keyframes mapped, " +
                      std::to_string(mapper_->waiting()) + " wait for a pose" +
                      (mapper_->level() ? "" : "; the grid waits for a level map"));
}

void DenseMapperProcess::publish_level(const LevelWish& wish) {
  constraint_t message{};
  message.utime = wish.utime_us;
  message.from_kind = graph_node_t::MAP;
  message.from_id = 0;
  message.to_kind = graph_node_t::KEYFRAME;
  message.to_id = wish.anchor_id;
  message.T_from_to = to_message(wish.T_level_anchor, wish.utime_us);
  to_message(level_covariance(wish.T_level_anchor, wish.floor_seen), message.covariance);
  message.source = "level";
  bus_.publish("LEVEL", message);
}

}  // namespace fusion_slam
