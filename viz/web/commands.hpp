// What the page's buttons do. Saving runs on a thread of its own; everything else is a COMMAND on
// the bus. Any thread.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "viz/web/protocol.hpp"
#include "viz/web/viewer_state.hpp"

namespace fusion_slam {

// COMMAND: target, verb, argument.
using SendCommand = std::function<void(const std::string&, const std::string&, const std::string&)>;

class Commands {
 public:
  // Without `send` (a replay) only saving works.
  Commands(ViewerState& state, std::filesystem::path save_directory, SendCommand send);
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  // Carries out a request of kind kCommand: {"ok": true|false, "text": what happens or why not}.
  nlohmann::ordered_json handle(const Request& request);

 private:
  nlohmann::ordered_json save();

  ViewerState& state_;
  const std::filesystem::path save_directory_;
  const SendCommand send_;
  std::mutex mutex_;
  std::atomic<bool> saving_{false};
  std::thread saver_;
};

}  // namespace fusion_slam
