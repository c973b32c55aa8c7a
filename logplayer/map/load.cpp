#include <atomic>
#include <csignal>
#include <iostream>

#include "libs/bus/bus.hpp"
#include "libs/map_directory/map_publisher.hpp"
#include "libs/map_directory/map_reader.hpp"
#include "logplayer/map/commands.hpp"

namespace fusion_slam {
namespace {

std::atomic<Bus*> running_bus{nullptr};

void on_signal(int) {
  if (Bus* bus = running_bus.load()) bus->stop();
}

}  // namespace

int load_map(const MapOptions& options) {
  const MapReader reader(options.map);
  const MapState state = read_state(reader);
  std::cout << options.map.string() << ": whole; " << describe(reader.summary()) << std::flush;
  if (options.check_only) return 0;
  BusOptions bus_options;
  bus_options.process = "map";
  bus_options.url = options.lcm_url;
  Bus bus(bus_options);
  const std::shared_ptr<void> no_signals_after(nullptr, [](void*) { running_bus = nullptr; });
  running_bus = &bus;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  const MapPublisher publisher(bus, state);
  publisher.say_models();
  publisher.say_graph();
  publisher.say_tiles();
  bus.every(1000, [&] {
    publisher.say_models();
    publisher.say_graph();
  });
  bus.set_state_text("publishing " + options.map.string());
  std::cout << "published; answering late listeners until Ctrl-C" << std::endl;
  bus.run();
  return 0;
}

}  // namespace fusion_slam
