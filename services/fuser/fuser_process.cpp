#include "services/fuser/fuser_process.hpp"

#include <string>

#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {

FuserProcess::FuserProcess(Bus& bus)
    : bus_(bus), lidar_out_(bus, "GRID_LIDAR"), fused_out_(bus, "GRID_FUSED") {
  bus.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly,
                               [this](const robot_model_t& m) { on_robot_model(m); });
  bus.subscribe<graph_t>("GRAPH", Policy::kKeepAll, [this](const graph_t& m) { on_graph(m); });
  bus.subscribe<command_t>("COMMAND", Policy::kKeepAll,
                           [this](const command_t& m) { on_command(m); });
  submap_in_ = std::make_unique<TileReceiver>(bus, "SUBMAP",
                                              [this](const Tile& tile) { on_tile(tile, false); });
  visual_in_ = std::make_unique<TileReceiver>(bus, "GRID_VISUAL",
                                              [this](const Tile& tile) { on_tile(tile, true); });
  bus.never_await({"SUBMAP", "GRID_VISUAL", "GRAPH", "COMMAND"});  // the order does not matter
  bus.keep_in_journal({"ROBOT_MODEL"});  // tiles and graph come again from who made them
  bus.set_state_text("waiting for ROBOT_MODEL");
}

void FuserProcess::on_robot_model(const robot_model_t& message) {
  if (fuser_) return;
  std::string why;
  const auto model = from_message(message, &why);
  if (!model) {
    bus_.report_error("ROBOT_MODEL: " + why);
    return;
  }
  fuser_ = std::make_unique<Fuser>(model->map_resolution_m, FuserConfig{});
  for (const auto& [key, tile] : early_submap_) add_tile(tile, false);
  for (const auto& [key, tile] : early_visual_) add_tile(tile, true);
  for (const graph_t& graph : early_graph_) on_graph(graph);
  early_submap_.clear();
  early_visual_.clear();
  early_graph_.clear();
  bus_.set_state_text("fusing");
  publish_if_due();
}

void FuserProcess::on_graph(const graph_t& message) {
  if (!fuser_) {
    early_graph_.push_back(message);
    return;
  }
  for (const graph_node_t& node : message.nodes) {
    if (!reset_.passes(node.utime)) continue;
    at_once_ = false;
    if (node.kind != graph_node_t::LIDAR) continue;
    const auto T_map_submap = from_message(node.T_map_base);
    if (T_map_submap)
      fuser_->set_anchor(node.id, *T_map_submap, message.utime);
    else
      bus_.report_error("GRAPH: pose of LiDAR node " + std::to_string(node.id) + " is not a pose");
  }
  if (message.part + 1 >= message.n_parts) publish_if_due();
}

void FuserProcess::on_tile(const Tile& tile, bool visual) {
  if (!fuser_) {
    (visual ? early_visual_ : early_submap_)[tile.key] = tile;
    return;
  }
  add_tile(tile, visual);
  publish_if_due();
}

void FuserProcess::add_tile(const Tile& tile, bool visual) {
  const bool good = visual ? fuser_->add_visual_tile(tile) : fuser_->add_submap_tile(tile);
  if (good) return;
  bus_.report_error(std::string(visual ? "GRID_VISUAL" : "SUBMAP") + ": tile " +
                    std::to_string(tile.key.x) + ", " + std::to_string(tile.key.y) + " of submap " +
                    std::to_string(tile.key.submap_id) + " is damaged or of another resolution");
}

void FuserProcess::on_command(const command_t& message) {
  if (reset_.asks(message)) {
    finished_ = false;
    at_once_ = true;
    early_graph_.clear();
    return publish_if_due();
  }
  if (message.verb != "finish" || !(message.target.empty() || message.target == "fuser")) return;
  finished_ = true;
  publish_if_due();
}

void FuserProcess::publish_if_due() {
  const bool exact = finished_ || at_once_;
  if (!fuser_ || !(exact || fuser_->due())) return;
  const FuserOutput output = fuser_->update(exact);
  for (const Tile& tile : output.lidar) lidar_out_.publish(tile);
  for (const Tile& tile : output.fused) fused_out_.publish(tile);
}

}  // namespace fusion_slam
