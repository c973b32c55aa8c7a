#include "libs/bus/process.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>

#include <CLI/CLI.hpp>

#include "fusion_slam/command_t.hpp"
#include "libs/clock/clock.hpp"

namespace fusion_slam {
namespace {

std::atomic<Bus*> running_bus{nullptr};

void on_signal(int) {
  if (Bus* bus = running_bus.load()) bus->stop();
}

// Two processes of one name would answer each other's inputs and number the same channels. STATUS
// comes once a second: whoever is younger than 5 s when it hears an elder's ends.
class TwinWatch {
 public:
  TwinWatch(Bus& bus, const BusOptions& options) {
    if (options.mode != Mode::kLive) return;
    const std::int64_t started_us = steady_us();
    bus.listen<status_t>(
        "STATUS", [found = found_, &bus, me = bus.status(), started_us](const status_t& other) {
          const bool is_me = other.pid == me.pid && other.host == me.host;
          if (other.process != me.process || is_me || other.state != status_t::RUNNING) return;
          const std::string where = other.process + " runs already (process " +
                                    std::to_string(other.pid) + " on " + other.host + ")";
          const std::lock_guard<std::mutex> lock(found->mutex);
          if (steady_us() - started_us > kYoung_us) {
            if (!found->told) bus.report_error("a second one was started: " + where);
            found->told = true;
            return;
          }
          found->problem = where + ": two of them would disturb each other. Stop that one first";
          bus.stop();
        });
    const std::int64_t until_us = started_us + kListen_us;
    while (problem().empty() && steady_us() < until_us)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }

  // Empty: this one may run.
  std::string problem() const {
    const std::lock_guard<std::mutex> lock(found_->mutex);
    return found_->problem;
  }

 private:
  static constexpr std::int64_t kYoung_us = 5'000'000;
  static constexpr std::int64_t kListen_us = 1'200'000;
  struct Found {  // outlives this object in the callback
    std::mutex mutex;
    std::string problem;
    bool told = false;
  };
  std::shared_ptr<Found> found_ = std::make_shared<Found>();
};

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
  std::string journal_folder;
  if (const char* folder = std::getenv("FUSION_SLAM_JOURNAL")) journal_folder = folder;
  app.add_option(
      "--journal", journal_folder,
      "live: a folder for what must survive a crash, a new one for each session (default: "
      "FUSION_SLAM_JOURNAL, else none)");
  if (add_options) add_options(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    if (!journal_folder.empty()) {
      std::filesystem::create_directories(journal_folder);
      options.journal = std::filesystem::path(journal_folder) / (name + ".lcmlog");
    }
    Bus bus(options);
    TwinWatch twin(bus, options);
    const std::shared_ptr<void> no_signals_after(nullptr, [](void*) { running_bus = nullptr; });
    running_bus = &bus;
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    bus.listen<command_t>("COMMAND", [&](const command_t& command) {
      if (command.verb == "quit" && (command.target.empty() || command.target == name)) bus.stop();
    });
    const std::shared_ptr<void> process = make(bus);
    if (twin.problem().empty()) bus.run();
    if (!twin.problem().empty()) throw std::runtime_error(twin.problem());
  } catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << std::endl;
    return 1;
  }
  return 0;
}

}  // namespace fusion_slam
