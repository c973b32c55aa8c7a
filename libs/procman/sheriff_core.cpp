#include "libs/procman/sheriff_core.hpp"

#include <algorithm>
#include <csignal>
#include <limits>
#include <set>

#include <sys/wait.h>

namespace fusion_slam {
namespace {

std::int32_t next_runid(std::int32_t a, std::int32_t b) {
  const std::int32_t last = std::max({a, b, 0});
  return last == std::numeric_limits<std::int32_t>::max() ? 1 : last + 1;
}

bool ended_as_asked(const CommandStatus& status) {
  if (!WIFSIGNALED(status.exit_code)) return false;
  const int signal = WTERMSIG(status.exit_code);
  return signal == status.spec.stop_signal || signal == SIGTERM || signal == SIGINT ||
         signal == SIGKILL;
}

}  // namespace

const char* to_string(CommandState state) {
  switch (state) {
    case CommandState::kUnknown:
      return "unknown";
    case CommandState::kStarting:
      return "starting";
    case CommandState::kRunning:
      return "running";
    case CommandState::kRestarting:
      return "restarting";
    case CommandState::kStopping:
      return "stopping";
    case CommandState::kStoppedWell:
      return "stopped";
    case CommandState::kStoppedError:
      return "FAILED";
  }
  return "";
}

CommandState SheriffCommand::state() const {
  if (!actual) return CommandState::kUnknown;
  const bool runs = actual->pid > 0;
  if (desired_runid != actual->actual_runid && !force_quit)
    return runs ? CommandState::kRestarting : CommandState::kStarting;
  if (runs) return force_quit || removing ? CommandState::kStopping : CommandState::kRunning;
  const bool asked = force_quit || removing;
  const bool well = actual->exit_code == 0 || (asked && ended_as_asked(*actual));
  return well ? CommandState::kStoppedWell : CommandState::kStoppedError;
}

SheriffCommand* SheriffCore::find(const std::string& id) {
  const auto it = commands_.find(id);
  return it == commands_.end() ? nullptr : &it->second;
}

void SheriffCore::load(const LabConfig& config) {
  for (const LabCommand& wanted : config.commands) {
    SheriffCommand& command = commands_[wanted.spec.id];
    command.spec = wanted.spec;
    command.deputy = wanted.deputy;
  }
}

void SheriffCore::hear(const DeputyInfo& info, std::int64_t utime_us, std::int64_t now_us) {
  deputies_[info.deputy] = {info.load, now_us, info.utime_us - utime_us};
  std::set<std::string> said;
  for (const CommandStatus& status : info.commands) {
    std::string id = status.spec.id;
    if (SheriffCommand* same = find(id); same != nullptr && same->deputy != info.deputy)
      id += "@" + info.deputy;
    said.insert(id);
    const auto [it, fresh] = commands_.try_emplace(id);
    SheriffCommand& command = it->second;
    if (fresh) {
      command.spec = status.spec;
      command.deputy = info.deputy;
    }
    if (!command.actual && command.force_quit && command.desired_runid == 0) {
      command.desired_runid = status.actual_runid;
      command.force_quit = status.pid == 0 && !status.spec.auto_respawn;
    }
    command.actual = status;
    // It has run to its end and shall not run again when its deputy is started anew.
    if (status.pid == 0 && status.actual_runid == command.desired_runid &&
        !command.spec.auto_respawn && status.exit_code == 0)
      command.force_quit = true;
  }
  for (auto it = commands_.begin(); it != commands_.end();) {
    SheriffCommand& command = it->second;
    const bool gone = command.deputy == info.deputy && said.count(it->first) == 0;
    if (gone && command.removing) {
      it = commands_.erase(it);
      continue;
    }
    if (gone) command.actual.reset();  // the deputy was started anew: it learns of it by the orders
    ++it;
  }
}

void SheriffCore::start(const std::string& id) {
  SheriffCommand* command = find(id);
  if (command == nullptr) return;
  const bool runs = command->actual && command->actual->pid > 0;
  if (runs && !command->force_quit && !command->removing) return;
  if (!command->force_quit && command->actual &&
      command->desired_runid != command->actual->actual_runid)
    return;  // it is being started
  restart(id);
}

void SheriffCore::restart(const std::string& id) {
  SheriffCommand* command = find(id);
  if (command == nullptr) return;
  command->desired_runid =
      next_runid(command->desired_runid, command->actual ? command->actual->actual_runid : 0);
  command->force_quit = command->removing = false;
}

void SheriffCore::stop(const std::string& id) {
  if (SheriffCommand* command = find(id)) command->force_quit = true;
}

void SheriffCore::remove(const std::string& id) {
  if (SheriffCommand* command = find(id)) command->force_quit = command->removing = true;
}

std::vector<Orders> SheriffCore::orders(std::int64_t utime_us) const {
  std::vector<Orders> result;
  for (const auto& [deputy, view] : deputies_) {
    Orders orders;
    orders.utime_us = utime_us;
    orders.deputy = deputy;
    orders.sheriff = sheriff_;
    for (const auto& [id, command] : commands_)
      if (command.deputy == deputy && !command.removing)
        orders.commands.push_back({command.spec, command.desired_runid, command.force_quit});
    result.push_back(std::move(orders));
  }
  return result;
}

bool SheriffCore::all(const std::vector<std::string>& ids, WaitFor wanted) const {
  return std::all_of(ids.begin(), ids.end(), [&](const std::string& id) {
    const auto it = commands_.find(id);
    if (it == commands_.end()) return wanted != WaitFor::kRunning;
    const CommandState state = it->second.state();
    const bool over = state == CommandState::kStoppedWell || state == CommandState::kStoppedError;
    if (wanted == WaitFor::kRunning) return state == CommandState::kRunning || over;
    if (wanted == WaitFor::kStopped) return over;
    return true;
  });
}

}  // namespace fusion_slam
