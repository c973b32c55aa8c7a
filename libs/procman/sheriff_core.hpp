// A sheriff's mind: what it wants, what deputies say, and the orders that follow. No network, no
// clock. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/procman/lab_config.hpp"

namespace fusion_slam {

enum class CommandState {
  kUnknown,  // its deputy has not spoken of it
  kStarting,
  kRunning,
  kRestarting,
  kStopping,
  kStoppedWell,   // exit code 0, or ended by the signal that was asked for
  kStoppedError,  // another exit code, a crash, or it could not be started
};
const char* to_string(CommandState state);

struct SheriffCommand {
  std::string deputy;
  CommandSpec spec;
  std::int32_t desired_runid = 0;
  bool force_quit = true;
  bool removing = false;
  std::optional<CommandStatus> actual;  // as its deputy said last

  CommandState state() const;
};

struct DeputyView {
  MachineLoad load;
  std::int64_t heard_us = 0;   // monotonic, of this machine
  std::int64_t offset_us = 0;  // its clock minus ours, and the message's way
};

class SheriffCore {
 public:
  explicit SheriffCore(std::string sheriff) : sheriff_(std::move(sheriff)) {}

  // The configuration's commands are wanted from now on, stopped unless they run already.
  void load(const LabConfig& config);
  // What a deputy says. A command that is news to us is adopted as it is: a sheriff that starts
  // finds everything as its predecessor left it.
  void hear(const DeputyInfo& info, std::int64_t utime_us, std::int64_t now_us);

  void start(const std::string& id);    // nothing happens to one that runs
  void restart(const std::string& id);  // also starts it
  void stop(const std::string& id);
  void remove(const std::string& id);  // stops it, and its deputy forgets it

  // The orders for all deputies that have been heard; for the others the sheriff can't know what
  // runs there.
  std::vector<Orders> orders(std::int64_t utime_us) const;

  // In order of deputy and id.
  const std::map<std::string, SheriffCommand>& commands() const { return commands_; }
  const std::map<std::string, DeputyView>& deputies() const { return deputies_; }
  const std::string& name() const { return sheriff_; }
  // True when each of these is running, or stopped. As with procman's sheriff a command that has
  // ended was running (a script never times out: it would wait for ever for a short one).
  bool all(const std::vector<std::string>& ids, WaitFor state) const;

 private:
  SheriffCommand* find(const std::string& id);

  std::string sheriff_;
  std::map<std::string, SheriffCommand> commands_;  // by id; of two with the same id on different
                                                    // deputies the other is "id@deputy"
  std::map<std::string, DeputyView> deputies_;
};

}  // namespace fusion_slam
