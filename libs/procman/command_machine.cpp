#include "libs/procman/command_machine.hpp"

#include <algorithm>
#include <utility>

namespace fusion_slam {
namespace {

constexpr std::int32_t kNotStarted = 127 << 8;  // as a shell's exit code 127

}  // namespace

void CommandMachine::order(const DesiredCommand& desired) {
  status_.spec = desired.spec;
  // 0: a sheriff that has just started and does not know yet what runs here. Leave it as it is.
  const std::int32_t runid =
      desired.desired_runid == 0 ? status_.actual_runid : desired.desired_runid;
  if (runid != desired_runid_) pause_us_ = kShortestPause_us;
  desired_runid_ = runid;
  force_quit_ = desired.force_quit;
  // A run that is over or was never begun and is not wanted any more takes the runid of the order,
  // 0 as well: procman's sheriff takes no command for stopped whose runid is not the one that it
  // asked for, and one that stops a command before it has heard of its runid asks for 0 for ever.
  if (force_quit_ && status_.pid == 0)
    status_.actual_runid = desired_runid_ = desired.desired_runid;
  removing_ = false;
  if (force_quit_ || !status_.spec.auto_respawn) respawn_ = false;
}

CommandMachine::Action CommandMachine::step(std::int64_t now_us) {
  if (status_.pid != 0) {
    if (!stop_begun_) {
      if (wanted() && desired_runid_ == status_.actual_runid) return Action::kNothing;
      stop_begun_ = true;
      stop_begun_us_ = now_us;
      return Action::kSignal;
    }
    const auto allowed_us = static_cast<std::int64_t>(1e6 * status_.spec.stop_time_allowed_s);
    if (killed_ || now_us - stop_begun_us_ < allowed_us) return Action::kNothing;
    killed_ = true;
    return Action::kKill;
  }
  if (!wanted()) return Action::kNothing;
  const bool ordered = desired_runid_ != status_.actual_runid;
  const bool again = respawn_ && now_us >= respawn_at_us_;
  return ordered || again ? Action::kStart : Action::kNothing;
}

void CommandMachine::begin_run() {
  status_.actual_runid = desired_runid_;
  stop_begun_ = killed_ = respawn_ = false;
}

void CommandMachine::started(std::int32_t pid, std::int64_t now_us) {
  begin_run();
  status_.pid = pid;
  status_.exit_code = 0;
  started_us_ = now_us;
}

void CommandMachine::could_not_start(std::int64_t now_us) {
  begin_run();
  status_.exit_code = kNotStarted;
  started_us_ = now_us;
  plan_respawn(now_us);
}

void CommandMachine::exited(std::int32_t wait_status, std::int64_t now_us) {
  status_.pid = 0;
  status_.exit_code = wait_status;
  status_.cpu_usage = 0.0F;
  status_.vsize_bytes = status_.rss_bytes = 0;
  const bool asked = std::exchange(stop_begun_, false);
  if (!asked) plan_respawn(now_us);
}

void CommandMachine::plan_respawn(std::int64_t now_us) {
  if (!status_.spec.auto_respawn || !wanted()) return;
  if (now_us - started_us_ >= kGoodRun_us) pause_us_ = kShortestPause_us;
  respawn_ = true;
  respawn_at_us_ = now_us + pause_us_;
  pause_us_ = std::min(2 * pause_us_, kLongestPause_us);
}

}  // namespace fusion_slam
