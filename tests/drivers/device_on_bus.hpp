// A driver's process on a private bus that runs in a thread of its own, and the world that hears
// it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "fusion_slam/command_t.hpp"
#include "libs/bus/transport.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {

// Process: the driver's, made of (Bus&, ...).
template <typename Process>
class DeviceOnBus : public testing::Test {
 protected:
  explicit DeviceOnBus(const std::string& process)
      : bus_(test_bus(process), transport_), world_(test_bus("world"), transport_) {}
  ~DeviceOnBus() override { finish(); }

  template <typename... Arguments>
  void run(Arguments&&... arguments) {
    process_ = std::make_unique<Process>(bus_, std::forward<Arguments>(arguments)...);
    runner_ = std::thread([this] { bus_.run(); });
  }
  void finish() {
    bus_.stop();
    if (runner_.joinable()) runner_.join();
    process_.reset();
  }
  bool soon(const std::function<bool()>& condition) {
    for (int i = 0; i < 3000 && !condition(); ++i) world_.handle(10);
    return condition();
  }
  void command(const std::string& target, const std::string& verb) {
    command_t command{};
    command.target = target;
    command.verb = verb;
    world_.publish("COMMAND", command);
  }
  bool said(const std::string& error) {
    return soon([&] { return bus_.status().last_error.find(error) != std::string::npos; });
  }

  std::shared_ptr<Transport> transport_ = std::make_shared<Transport>("memq://");
  Bus bus_, world_;
  std::unique_ptr<Process> process_;
  std::thread runner_;
};

}  // namespace fusion_slam
