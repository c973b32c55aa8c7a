#include "libs/map_directory/map_publisher.hpp"

namespace fusion_slam {

void MapPublisher::say_models() const {
  bus_.publish("ROBOT_MODEL", state_.robot_message);
  if (state_.camera_message) bus_.publish("CAMERA_MODEL", *state_.camera_message);
}

void MapPublisher::say_graph() const {
  for (const graph_t& part : state_.graph.messages()) bus_.publish("GRAPH", part);
}

void MapPublisher::say_tiles() const {
  for (const auto& [channel, tiles] : state_.tiles)
    if (channel != "SUBMAP")
      for (const auto& [key, tile] : tiles) bus_.publish_tile(channel, tile);
}

}  // namespace fusion_slam
