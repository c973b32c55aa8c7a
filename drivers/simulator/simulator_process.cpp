#include "drivers/simulator/simulator_process.hpp"

#include <cstdio>
#include <exception>
#include <iostream>

namespace fusion_slam {
namespace {

constexpr int kTellMs = 1000;

}  // namespace

SimulatorProcess::SimulatorProcess(Bus& bus, const SimulationArguments& arguments)
    : SimulatorProcess(bus, read_simulation(arguments)) {}

SimulatorProcess::SimulatorProcess(Bus& bus, const SimulationInput& input)
    : bus_(bus),
      simulation_(input.world, input.route, input.options),
      live_(simulation_, input.options.threads,
            [this](const std::string& channel, const Bytes& bytes) {
              bus_.publish_bytes(channel, bytes);
            }) {
  bus_.set_state_text("preparing the world");
  bus_.every(kTellMs, [this] { tell(); });
  thread_ = std::thread([this] {
    try {
      live_.run();
    } catch (const std::exception& error) {
      bus_.report_error(std::string("the run ended early: ") + error.what());
    }
    tell();
    bus_.stop();
  });
}

SimulatorProcess::~SimulatorProcess() {
  live_.stop();
  thread_.join();
  const LiveRun::Progress p = live_.progress();
  std::cerr << "simulator: " << p.frames_published << " camera frames published, "
            << p.frames_dropped << " left out because the machine was too slow\n";
}

void SimulatorProcess::tell() {
  const LiveRun::Progress p = live_.progress();
  if (!p.started) return;
  char text[160];
  std::snprintf(text, sizeof text, "%.1f of %.1f s; %lld camera frames, %lld left out: too slow",
                p.time_s, simulation_.seconds(), static_cast<long long>(p.frames_published),
                static_cast<long long>(p.frames_dropped));
  bus_.set_state_text(text);
}

}  // namespace fusion_slam
