// Which fault from when to when.
#pragma once

#include <string>
#include <vector>

#include "tests/support/virtual_rplidar/virtual_rplidar.hpp"

namespace fusion_slam {

struct FaultChange {
  double at_s = 0.0;
  VirtualFault fault = VirtualFault::kNone;
};

// Of texts like "stall@5+2" (from second 5, for 2 seconds), in order of time. Throws
// std::invalid_argument.
std::vector<FaultChange> timetable(const std::vector<std::string>& texts);

}  // namespace fusion_slam
