// What else a robot's PC needs: programs, a clock, space on the disk.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libs/netcheck/check.hpp"

namespace fusion_slam {

// lcm-logger and lcm-logplayer (a fault when missing), lcm-spy, java, lcm-gen (a warning).
std::vector<CheckResult> check_programs();

// Where a program is on PATH; empty: nowhere.
std::filesystem::path find_program(const std::string& name);

// A date that can be, and whether the kernel calls the clock synchronised (several machines need
// that).
CheckResult check_clock();

// Space for recordings in `folder`: a fault below 1 GB, a warning below 10 GB.
CheckResult check_disk(const std::filesystem::path& folder);

}  // namespace fusion_slam
