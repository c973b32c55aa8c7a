// The fuser on the bus: SUBMAP, GRID_VISUAL, GRAPH, ROBOT_MODEL, COMMAND in; GRID_LIDAR, GRID_FUSED
// out.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "fusion_slam/command_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/reset_gate.hpp"
#include "libs/bus/tile_channel.hpp"
#include "services/fuser/fuser.hpp"

namespace fusion_slam {

class FuserProcess {
 public:
  explicit FuserProcess(Bus& bus);

 private:
  void on_robot_model(const robot_model_t& message);
  void on_graph(const graph_t& message);
  void on_command(const command_t& message);
  void on_tile(const Tile& tile, bool visual);
  void add_tile(const Tile& tile, bool visual);
  void publish_if_due();

  Bus& bus_;
  ResetGate reset_{"fuser"};
  TilePublisher lidar_out_;
  TilePublisher fused_out_;
  std::unique_ptr<Fuser> fuser_;  // made when ROBOT_MODEL has said the resolution
  bool finished_ = false;         // after COMMAND finish each input is answered at once
  // So it is after COMMAND reset, until the new map begins: the map is what the inputs say, the
  // mappers say of each old tile that it is gone, and the sensors may say nothing any more.
  bool at_once_ = false;
  // What came before ROBOT_MODEL.
  std::map<TileKey, Tile> early_submap_;
  std::map<TileKey, Tile> early_visual_;
  std::vector<graph_t> early_graph_;
  std::unique_ptr<TileReceiver> submap_in_;
  std::unique_ptr<TileReceiver> visual_in_;
};

}  // namespace fusion_slam
