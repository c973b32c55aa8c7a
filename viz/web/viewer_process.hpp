// The viewer on the bus: everything that the page shows in, COMMAND out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "libs/bus/bus.hpp"
#include "libs/bus/tile_channel.hpp"
#include "viz/web/viewer_state.hpp"

namespace fusion_slam {

class ViewerProcess {
 public:
  ViewerProcess(Bus& bus, ViewerState& state);

  // Publishes a COMMAND; any thread.
  void send(const std::string& target, const std::string& verb, const std::string& argument);

 private:
  template <class Message>
  void show(const std::string& channel, Policy policy);
  template <class Message>
  void hear(const std::string& channel);

  Bus& bus_;
  ViewerState& state_;
  std::vector<std::unique_ptr<TileReceiver>> tiles_;
};

}  // namespace fusion_slam
