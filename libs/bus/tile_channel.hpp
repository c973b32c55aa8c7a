// Large state as tiles: the sender keeps the newest of each, the receiver asks for what it lacks,
// so a listener that starts late or lost packets is whole again within 2 s.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "fusion_slam/tile_index_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/tiles/tile.hpp"

namespace fusion_slam {

class TilePublisher {
 public:
  TilePublisher(Bus& bus, std::string channel) : bus_(bus), channel_(std::move(channel)) {}

  // Sends the tile and keeps it for late listeners until a newer revision of the same key comes.
  void publish(const Tile& tile);
  // All tiles are gone, and listeners hear of it; what follows may count from revision 1 again.
  void clear() { bus_.clear_tiles(channel_); }

 private:
  Bus& bus_;
  std::string channel_;
};

// Construct before Bus::run(). on_tile is called on the bus's thread, once for each new revision of
// a key.
class TileReceiver {
 public:
  TileReceiver(Bus& bus, const std::string& channel, std::function<void(const Tile&)> on_tile);

 private:
  struct Shared;  // outlives this object in callbacks
  void receive(const tile_t& message);

  std::shared_ptr<Shared> shared_;
  std::function<void(const Tile&)> on_tile_;
};

}  // namespace fusion_slam
