// What the page's buttons do. Saving and the sheriff run on a thread of their own, one at a time;
// everything else is a COMMAND on the bus. Any thread.
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

// How processes are started and stopped: by the sheriff's command line.
struct Sheriff {
  std::filesystem::path program;  // procman-sheriff
  std::filesystem::path lab;      // lab configuration; empty: nothing can be started
  std::string lcm_url;
};

class Commands {
 public:
  // Without `send` (a replay) only saving works.
  Commands(ViewerState& state, std::filesystem::path save_directory, SendCommand send,
           Sheriff sheriff = {});
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  // Carries out a request of kind kCommand: {"ok": true|false, "text": what happens or why not}.
  nlohmann::ordered_json handle(const Request& request);

 private:
  nlohmann::ordered_json save();
  nlohmann::ordered_json order(const std::string& verb, const std::string& target);
  // Starts a job; false when another one is running.
  bool begin(std::function<void()> job);

  ViewerState& state_;
  const std::filesystem::path save_directory_;
  const SendCommand send_;
  const Sheriff sheriff_;
  std::mutex mutex_;
  std::atomic<bool> busy_{false};
  std::thread worker_;
};

}  // namespace fusion_slam
