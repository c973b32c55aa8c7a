// COMMAND reset, as every service obeys it: the old map goes, ids and revisions count on, and what
// is still under way of the old map is not taken for the new one. A reset takes its place among the
// measurements: its utime is the newest measurement's when it was asked for. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "fusion_slam/command_t.hpp"

namespace fusion_slam {

class ResetGate {
 public:
  explicit ResetGate(std::string process) : process_(std::move(process)) {}

  // True when this process has to start anew; from then on what was measured up to then is stale.
  bool asks(const command_t& command) {
    if (command.verb != "reset" || !(command.target.empty() || command.target == process_))
      return false;
    // Whose clock is far ahead of the sensors' must not shut us up.
    reset_us_ = command.utime <= newest_us_ + kMostAhead_us ? command.utime : newest_us_;
    return true;
  }

  // What is not newer is stale; a process that is started again begins with it. us since the epoch.
  std::int64_t border_us() const { return reset_us_; }
  void restore(std::int64_t border_us) {
    reset_us_ = border_us;
    newest_us_ = std::max(newest_us_, border_us);
  }

  // Of each input: false when it is of the map before the last reset. us since the epoch, when it
  // was measured.
  bool passes(std::int64_t utime_us) {
    newest_us_ = std::max(newest_us_, utime_us);
    return utime_us > reset_us_;
  }

 private:
  static constexpr std::int64_t kMostAhead_us = 60'000'000;
  std::string process_;
  std::int64_t newest_us_ = 0;
  std::int64_t reset_us_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace fusion_slam
