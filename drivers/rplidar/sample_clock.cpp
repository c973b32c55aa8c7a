#include "drivers/rplidar/sample_clock.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

// GET_SAMPLERATE gives whole microseconds: 0.5 in 250 is 2000 ppm, crystals add less than 100.
constexpr double kRise = 3e-3;
// Of arrival, not of samples: what waited in a buffer comes all at once, late and yet whole.
constexpr double kWindow_us = 500'000.0;
constexpr double kJump_us = 2'000.0;

}  // namespace

void SampleClock::bound(std::int64_t number, double latest_us) {
  const double offset_us = latest_us - static_cast<double>(number) * period_us_;
  const double rise_us = kRise * period_us_ * static_cast<double>(number - last_number_);
  offset_us_ = started_ ? std::min(offset_us, offset_us_ + rise_us) : offset_us;
  if (!started_ || latest_us - window_begin_us_ > kWindow_us) {
    if (started_ && lowest_us_ > offset_us_ + kJump_us) offset_us_ = lowest_us_;
    window_begin_us_ = latest_us;
    lowest_us_ = offset_us;
  }
  lowest_us_ = std::min(lowest_us_, offset_us);
  last_number_ = number;
  started_ = true;
}

std::int64_t SampleClock::utime_us(std::int64_t number) const {
  if (!started_) return 0;
  return std::llround(offset_us_ + static_cast<double>(number) * period_us_);
}

}  // namespace fusion_slam
