// What `fusion-slam doctor` prints.
#pragma once

#include <string>
#include <vector>

#include "libs/netcheck/check.hpp"

namespace fusion_slam {

bool has_fault(const std::vector<CheckResult>& results);

// A line a check, and under it the command that mends what is not good.
std::string text_report(const std::vector<CheckResult>& results);

// [{"name", "state": "good" | "warning" | "fault", "found", "command"}].
std::string json_report(const std::vector<CheckResult>& results);

// The commands that mend the faults, a line each, for a root shell.
std::string commands(const std::vector<CheckResult>& results);

}  // namespace fusion_slam
