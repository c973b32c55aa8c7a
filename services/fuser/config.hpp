// What the fuser can be told; everything else follows from the messages.
#pragma once

#include <cstdint>

namespace fusion_slam {

struct FuserConfig {
  // Changed tiles go out at most this often, measured in the utime of the inputs.
  std::int64_t publish_period_us = 1'000'000;
  // A submap is composed anew when the graph moved a point of it by more than this part of a cell:
  // less is not visible.
  double slack_cells = 0.25;
};

}  // namespace fusion_slam
