#include "services/dense_mapper/dense_mapper_process.hpp"

#include <algorithm>
#include <chrono>
#include <string>

#include "fusion_slam/constraint_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kMaxEarlyImages = 64;  // models come at 1 Hz, keyframes at a few Hz
// So many images are looked at before their poses have come; a cloud takes 1.3 MB, an image 80 KB.
constexpr std::size_t kLookedAtAhead = 16;
constexpr std::size_t kMaxPending = 512;

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

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
  keep_journal();
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
  go_on_where_it_ended();
  for (const graph_t& graph : early_graph_) take_graph(graph);
  for (const keyframe_image_t& image : early_images_) take_image(image);
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
  take_image(message);
  if (!bus_.recovering()) return integrate_and_publish();
  integrate();
  if (!went_on_) mapper_->pack_full();
}

// What can't be mapped yet waits as it came: a graph that is behind must not cost a gigabyte.
void DenseMapperProcess::take_image(const keyframe_image_t& message) {
  if (!reset_.passes(message.utime)) return;
  number_[message.id] = message.seq;
  if (bus_.recovering() && mapper_->has(message.id)) return;
  if (mapper_->ready(message.id)) return map_or_leave_out(message);
  if (mapper_->belongs_to_left_out(message.id)) return leave_out(message.id);
  if (mapper_->waiting() < kLookedAtAhead && !Pace::behind(queue())) return add_keyframe(message);
  pending_.emplace(message.id, message);
  if (pending_.size() <= kMaxPending) return;
  bus_.report_error("KEYFRAME_IMAGE " + std::to_string(pending_.begin()->first) +
                    ": the graph has not said where it is; dropped. Does pose_graph run?");
  pending_.erase(pending_.begin());
}

// When images come faster than they can be mapped, the queue must not grow for ever. A submap is
// left out as a whole: half of one costs as much to keep.
void DenseMapperProcess::map_or_leave_out(const keyframe_image_t& message) {
  const std::size_t waiting = queue();
  if (mapper_->belongs_to_left_out(message.id) ||
      (Pace::behind(waiting) && mapper_->repeats_a_place(message.id) && !pace_.maps_next(waiting)))
    leave_out(message.id);
  else
    add_keyframe(message);
}

void DenseMapperProcess::leave_out(std::int64_t id) {
  mapper_->leave_out(id);
  ++left_out_;
}

std::size_t DenseMapperProcess::queue() const {
  if (bus_.mode() != Mode::kLive || bus_.recovering()) return 0;
  return static_cast<std::size_t>(bus_.status().queue);
}

void DenseMapperProcess::integrate() {
  mapper_->integrate_ready();
  for (auto it = pending_.begin(); it != pending_.end();) {
    if (!mapper_->ready(it->first) && !mapper_->belongs_to_left_out(it->first)) {
      ++it;
      continue;
    }
    map_or_leave_out(it->second);
    mapper_->integrate_ready();
    it = pending_.erase(it);
  }
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
  // What the journal says of the map is of after that.
  if (bus_.recovering() && message.utime <= commands_upto_us_) return;
  commands_upto_us_ = std::max(commands_upto_us_, message.utime);
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
  pending_.clear();
  number_.clear();
  all_is_due_ = true;
  finished_ = false;
  begins_anew_ = true;
  pace_ = Pace();
  left_out_ = 0;
  for (TilePublisher* out : {&octomap_out_, &cloud_out_, &grid_out_}) out->clear();
  if (!mapper_) return;
  mapper_ = std::make_unique<DenseMapper>(*camera_, *robot_, DenseMapperConfig{});
  if (bus_.mode() == Mode::kLive) mapper_->keep_changes();
  integrate_and_publish();
}

void DenseMapperProcess::integrate_and_publish() {
  integrate();
  const bool live = bus_.mode() == Mode::kLive;
  if (live) {
    mapper_->follow_moves(pace_.may_follow(steady_s()));
    mapper_->follow_at_most(pace_.cubes_a_step());
  }
  if (finished_ || mapper_->due()) {
    if (const auto wish = mapper_->wish_level(finished_)) publish_level(*wish);
    const double begin_s = steady_s();
    const std::size_t before = mapper_->cubes_followed();
    publish_maps();
    const double end_s = steady_s();
    const std::size_t cubes = mapper_->cubes_followed() - before;
    if (live && cubes > 0) pace_.followed(end_s, end_s - begin_s, cubes, queue());
  }
  write_down();
  bus_.set_state_text(
      std::to_string(mapper_->integrated()) + " keyframes mapped, " +
      std::to_string(mapper_->waiting() + pending_.size()) + " wait for a pose" +
      (left_out_ == 0 ? ""
                      : ", " + std::to_string(left_out_) + " of known places left out to keep up") +
      (mapper_->level() ? "" : "; the grid waits for a level map"));
}

// The raster first: the fused map waits for it.
void DenseMapperProcess::publish_maps() {
  for (const Tile& tile : mapper_->update_grid(finished_).grid) grid_out_.publish(tile);
  const DenseTiles maps = mapper_->update_maps();
  for (const Tile& tile : maps.octomap) octomap_out_.publish(tile);
  for (const Tile& tile : maps.cloud) cloud_out_.publish(tile);
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
