// One command of a deputy: when to start it, signal it, kill it, start it again. A pure state
// machine: it is told the time and what happened, and says what to do. Not thread-safe.
#pragma once

#include <cstdint>
#include <utility>

#include "libs/procman/command.hpp"

namespace fusion_slam {

class CommandMachine {
 public:
  enum class Action { kNothing, kStart, kSignal, kKill };

  explicit CommandMachine(CommandSpec spec) { status_.spec = std::move(spec); }

  // The sheriff's wish. A changed `exec` counts from the next start. desired_runid 0 asks for no
  // other run than the one that is; with force_quit a stopped command takes it, whatever it is.
  void order(const DesiredCommand& desired);
  // The command is not in the orders any more: stop it. removable() when it has ended.
  void remove() { removing_ = true; }
  bool removable() const { return removing_ && status_.pid == 0; }

  // What to do at now_us (monotonic). kSignal: send spec.stop_signal. Each is said once.
  Action step(std::int64_t now_us);
  // After kStart: it runs, or could not be started.
  void started(std::int32_t pid, std::int64_t now_us);
  void could_not_start(std::int64_t now_us);
  // It ended; wait_status as waitpid(2) gives it.
  void exited(std::int32_t wait_status, std::int64_t now_us);

  const CommandStatus& status() const { return status_; }
  void set_load(float cpu_usage, std::int64_t vsize_bytes, std::int64_t rss_bytes) {
    status_.cpu_usage = cpu_usage;
    status_.vsize_bytes = vsize_bytes;
    status_.rss_bytes = rss_bytes;
  }
  bool stopping() const { return status_.pid != 0 && stop_begun_; }

  // A command that ends by itself is started again after 50 ms, then 100, 200 ... 10 s; one that
  // has run for 10 s begins anew.
  static constexpr std::int64_t kShortestPause_us = 50'000;
  static constexpr std::int64_t kLongestPause_us = 10'000'000;
  static constexpr std::int64_t kGoodRun_us = 10'000'000;

 private:
  void begin_run();
  bool wanted() const { return !force_quit_ && !removing_; }
  void plan_respawn(std::int64_t now_us);

  CommandStatus status_;
  std::int32_t desired_runid_ = 0;
  bool force_quit_ = false;
  bool removing_ = false;
  bool stop_begun_ = false;
  bool killed_ = false;
  bool respawn_ = false;  // at respawn_at_us_
  std::int64_t stop_begun_us_ = 0;
  std::int64_t started_us_ = 0;
  std::int64_t pause_us_ = kShortestPause_us;
  std::int64_t respawn_at_us_ = 0;
};

}  // namespace fusion_slam
