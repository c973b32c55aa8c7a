// The two clocks of a process, in LCM's unit. For programs only: algorithms take stamps from their
// messages (docs/contributing.md). Thread-safe.
#pragma once

#include <chrono>
#include <cstdint>

namespace fusion_slam {

// Since an arbitrary moment, never backward: for time-outs and durations. Microseconds.
inline std::int64_t steady_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Since 1970, as messages are stamped; may jump when the machine's clock is set. Microseconds.
inline std::int64_t wall_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace fusion_slam
