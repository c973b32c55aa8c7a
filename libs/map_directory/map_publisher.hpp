// A saved map on the bus: ROBOT_MODEL, CAMERA_MODEL, GRAPH and the composed maps' tiles, which the
// bus then keeps for late listeners. SUBMAPs stay at home: nobody but the mapper may speak for
// them.
#pragma once

#include "libs/bus/bus.hpp"
#include "libs/map_directory/map_reader.hpp"

namespace fusion_slam {

class MapPublisher {
 public:
  // Both must outlive this object.
  MapPublisher(Bus& bus, const MapState& state) : bus_(bus), state_(state) {}

  void say_models() const;
  void say_graph() const;
  void say_tiles() const;

 private:
  Bus& bus_;
  const MapState& state_;
};

}  // namespace fusion_slam
