#include <atomic>
#include <chrono>
#include <csignal>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#include "tests/support/virtual_rplidar/timetable.hpp"
#include "tests/support/virtual_rplidar/virtual_rplidar.hpp"

namespace {

std::atomic<bool> stop{false};

}  // namespace

int main(int argc, char** argv) {
  fusion_slam::VirtualRplidarOptions options;
  std::string log;
  std::vector<std::string> faults;
  CLI::App app{"virtual_rplidar: an RPLidar on a pseudo-terminal, fed by a log."};
  app.add_option("--link", options.link, "name of the port: a link to the pseudo-terminal")
      ->required();
  app.add_option("--log", log, "LCM log with LIDAR, or a MAEBot recording; without: a room");
  app.add_option("--model", options.model)
      ->check(CLI::IsMember(fusion_slam::virtual_model_names()));
  app.add_option("--rate", options.rate_hz, "turns a second (default: the log's)");
  app.add_option("--begin", options.begin_us,
                 "utime at which the first turn begins (default: now)");
  app.add_option("--seed", options.seed, "of noise and losses");
  app.add_option(
      "--fault", faults,
      "NAME@START+SECONDS, again and again: noise, loss, checksum, stall, unplug, health, "
      "descriptor, slow-motor");
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGINT, [](int) { stop = true; });
  std::signal(SIGTERM, [](int) { stop = true; });
  try {
    options.world =
        log.empty() ? fusion_slam::virtual_room(18, 360) : fusion_slam::read_virtual_world(log);
    const auto changes = fusion_slam::timetable(faults);
    fusion_slam::VirtualRplidar device(options);
    std::cout << options.link.string() << ": " << options.model << ", "
              << options.world.turns.size() << " turns" << std::endl;
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t next = 0; !stop;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
      for (; next < changes.size() && changes[next].at_s <= passed.count(); ++next) {
        device.set_fault(changes[next].fault);
        std::cout << passed.count() << " s: " << fusion_slam::to_string(changes[next].fault)
                  << std::endl;
      }
    }
  } catch (const std::exception& error) {
    std::cerr << "virtual_rplidar: " << error.what() << std::endl;
    return 1;
  }
  return 0;
}
