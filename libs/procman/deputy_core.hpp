// A deputy's mind: which orders it takes, and what its commands need next. No network, no
// processes, no clock. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "libs/procman/command_machine.hpp"

namespace fusion_slam {

enum class OrdersVerdict {
  kTaken,
  kForAnother,    // deputy
  kTooOld,        // or too far in the future: more than 60 s off this machine's clock
  kOlder,         // than the last that was taken
  kOtherSheriff,  // another one has given orders within the last 3 s
};
const char* to_string(OrdersVerdict verdict);

class DeputyCore {
 public:
  // oldest_utime_us: orders made before are refused (a deputy that asks for signed orders gives its
  // own start, so that nobody can replay what was recorded before); 0: none.
  explicit DeputyCore(std::string deputy, std::int64_t oldest_utime_us = 0)
      : deputy_(std::move(deputy)), last_utime_us_(oldest_utime_us) {}

  // utime_us is this machine's wall clock, now_us monotonic.
  OrdersVerdict take(const Orders& orders, std::int64_t utime_us, std::int64_t now_us);
  // The sheriff says good-bye: another may give orders at once.
  void sheriff_left(const std::string& sheriff);
  // Orders, as if a sheriff had said so: stop everything (this deputy ends).
  void stop_all();

  struct Step {
    std::string id;
    CommandMachine::Action action = CommandMachine::Action::kNothing;
  };
  // What to do now, in order of ids; forgets commands that were removed and have ended.
  std::vector<Step> steps(std::int64_t now_us);

  CommandMachine* find(const std::string& id);
  const std::map<std::string, CommandMachine>& commands() const { return commands_; }
  const std::string& deputy() const { return deputy_; }
  const std::string& sheriff() const { return sheriff_; }  // whose orders were taken last
  bool any_running() const;

  static constexpr std::int64_t kGreatestAge_us = 60'000'000;
  static constexpr std::int64_t kSheriffHolds_us = 3'000'000;
  static constexpr std::size_t kMostCommands = 1000;

 private:
  std::string deputy_;
  std::map<std::string, CommandMachine> commands_;
  std::string sheriff_;
  std::int64_t last_utime_us_ = 0;
  std::int64_t sheriff_until_us_ = 0;
  bool ending_ = false;
};

}  // namespace fusion_slam
