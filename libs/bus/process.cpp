#include "libs/bus/process.hpp"

#include <atomic>
#include <csignal>
#include <iostream>
#include <map>

#include <CLI/CLI.hpp>

#include "fusion_slam/command_t.hpp"

namespace fusion_slam {
namespace {

std::atomic<Bus*> running_bus{nullptr};

void on_signal(int) {
  if (Bus* bus = running_bus.load()) bus->stop();
}

}  // namespace

const char* to_string(Mode mode) {
  switch (mode) {
    case Mode::kThroughput:
      return "throughput";
    case Mode::kLockstep:
      return "lockstep";
    case Mode::kLive:
      break;
  }
  return "live";
}

int process_main(int argc, char** argv, const std::string& name, const std::string& description,
                 const std::function<std::shared_ptr<void>(Bus&)>& make,
                 const std::function<void(CLI::App&)>& add_options) {
  BusOptions options;
  options.process = name;
  CLI::App app{name + ": " + description};
  app.add_option("--lcm-url", options.url,
                 "LCM network (default: LCM_DEFAULT_URL, else LCM's own)");
  const std::map<std::string, Mode> modes{
      {"live", Mode::kLive}, {"throughput", Mode::kThroughput}, {"lockstep", Mode::kLockstep}};
  app.add_option("--mode", options.mode,
                 "live: the robot's clock drives; throughput, lockstep: a replay drives")
      ->transform(CLI::CheckedTransformer(modes))
      ->default_str("live");
  if (add_options) add_options(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    Bus bus(options);
    const std::shared_ptr<void> no_signals_after(nullptr, [](void*) { running_bus = nullptr; });
    running_bus = &bus;
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    bus.listen<command_t>("COMMAND", [&](const command_t& command) {
      if (command.verb == "quit" && (command.target.empty() || command.target == name)) bus.stop();
    });
    const std::shared_ptr<void> process = make(bus);
    bus.run();
  } catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << std::endl;
    return 1;
  }
  return 0;
}

}  // namespace fusion_slam
