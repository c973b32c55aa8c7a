// The clocks of the bus and of programs around it. Algorithms never ask them.
#pragma once

#include <cstdint>

namespace fusion_slam {

std::int64_t now_us();         // monotonic
std::int64_t wall_utime_us();  // since the epoch; for STATUS and requests only

}  // namespace fusion_slam
