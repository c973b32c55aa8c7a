// Tells a clock that was set back from a message that comes late: what is said later (by its
// number) was measured earlier.
#pragma once

#include <cstdint>

namespace fusion_slam {

class ClockWatch {
 public:
  // True: between this message and the one before it the clock was set back by a second or more.
  bool was_set_back(std::int64_t seq, std::int64_t utime_us) {
    const bool next = seq > seq_ || utime_us > utime_us_;  // or of a publisher that counts anew
    const bool back = next && seq_ > 0 && utime_us < utime_us_ - kBack_us;
    if (next) {
      seq_ = seq;
      utime_us_ = utime_us;
    }
    return back;
  }

 private:
  static constexpr std::int64_t kBack_us = 1'000'000;  // stamps of one sensor vary by far less
  std::int64_t seq_ = 0;
  std::int64_t utime_us_ = 0;
};

}  // namespace fusion_slam
