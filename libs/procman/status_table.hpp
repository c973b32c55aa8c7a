// What a sheriff knows, for people and for programs.
#pragma once

#include <cstdint>
#include <string>

#include "libs/procman/sheriff_core.hpp"

namespace fusion_slam {

// A line a machine (load, memory, when last heard), and a line a command: deputy, group, name,
// state, pid, CPU (of the whole machine), memory, how it ended.
std::string status_table(const SheriffCore& sheriff, std::int64_t now_us);

// The same as JSON: {"deputies": [...], "commands": [...]}.
std::string status_json(const SheriffCore& sheriff, std::int64_t now_us);

// "exit code 3", "signal 11 (Segmentation fault)", "could not be started", "" when it runs or never
// ran. `exit_code` as waitpid(2) gives it.
std::string how_it_ended(const CommandStatus& status);

}  // namespace fusion_slam
