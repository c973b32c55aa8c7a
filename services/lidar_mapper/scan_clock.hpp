// Plausible time between scans from stamps that may jump, repeat, be rounded to 10 ms or run
// backwards.
#pragma once

#include <cstdint>
#include <deque>

namespace fusion_slam {

class ScanClock {
 public:
  explicit ScanClock(double nominal_rate_hz);

  struct Interval {
    double dt_s = 0.0;  // since the last scan; never near 0: what physics would need
    bool trusted =
        false;  // the stamps said so; false: they can't be right and dt_s is the usual period
  };
  Interval advance(std::int64_t utime_us);

  double period_s() const;  // median of the recent intervals; the sensor's nominal one at first

 private:
  double nominal_s_;
  std::int64_t last_us_ = 0;
  bool started_ = false;
  std::deque<double> recent_s_;
};

}  // namespace fusion_slam
