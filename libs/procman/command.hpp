// What sheriffs and deputies say to each other, without the wire: libs/messages/procman.hpp turns
// it into procman's LCM types. Semantics: procman's own, as its published protocol describes them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fusion_slam {

struct CommandSpec {
  std::string id;     // unique within a deputy
  std::string exec;   // NAME=VALUE ... program argument ...; evaluated by the deputy
  std::string group;  // "outer/inner"; empty: none
  bool auto_respawn = false;
  int stop_signal = 2;               // sent first; SIGKILL follows
  double stop_time_allowed_s = 7.0;  // between the two
};

inline bool operator==(const CommandSpec& a, const CommandSpec& b) {
  return a.id == b.id && a.exec == b.exec && a.group == b.group &&
         a.auto_respawn == b.auto_respawn && a.stop_signal == b.stop_signal &&
         a.stop_time_allowed_s == b.stop_time_allowed_s;
}

// What the sheriff wants of a command. A desired_runid that the deputy has not started yet starts
// (or restarts) it, unless force_quit.
struct DesiredCommand {
  CommandSpec spec;
  std::int32_t desired_runid = 0;
  bool force_quit = false;
};

// What a deputy says of a command.
struct CommandStatus {
  CommandSpec spec;
  std::int32_t pid = 0;           // 0: not running
  std::int32_t actual_runid = 0;  // the run that was started last
  std::int32_t exit_code = 0;     // of that run when it has ended, as waitpid(2) gives it
  float cpu_usage = 0.0F;         // share of the machine, 0 to 1
  std::int64_t vsize_bytes = 0;
  std::int64_t rss_bytes = 0;
};

struct MachineLoad {
  float cpu_load = 0.0F;  // 0 to 1
  std::int64_t memory_total_bytes = 0;
  std::int64_t memory_free_bytes = 0;
  std::int64_t swap_total_bytes = 0;
  std::int64_t swap_free_bytes = 0;
};

struct DeputyInfo {
  std::int64_t utime_us = 0;
  std::string deputy;
  MachineLoad load;
  std::vector<CommandStatus> commands;
};

struct Orders {
  std::int64_t utime_us = 0;
  std::string deputy;
  std::string sheriff;
  std::vector<DesiredCommand>
      commands;  // all the deputy shall know: others are stopped and removed
};

}  // namespace fusion_slam
