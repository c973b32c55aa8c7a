// When was a scan really measured? A scanner turns evenly, but its stamps are those of a computer
// that was busy: rounded to 10 ms, late by half a period, repeated, backwards. The clock finds the
// period and phase of the turning behind the stamps (passive synchronisation after Olson 2010, "A
// passive solution to the sensor synchronization problem", with the number of turns as the sensor's
// clock) and says how much time really passed.
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
    // The stamp less the time of measurement as the even turning has it; the mean delay, which
    // stamps alone can't tell, counts as 0. Within half a period; 0 while no even turning is seen.
    double late_s = 0.0;
  };
  Interval advance(std::int64_t utime_us);

  double period_s() const;  // median of the recent intervals; the sensor's nominal one at first
  bool locked() const { return locked_; }  // an even turning explains the recent stamps

 private:
  double even_time(double stamp_s);
  void find_period();

  double nominal_s_;
  std::int64_t last_us_ = 0;
  std::int64_t first_us_ = 0;
  bool started_ = false;
  std::deque<double> recent_s_;  // intervals
  std::deque<double> stamps_s_;  // since first_us_, the latest
  double turning_s_ = 0.0;       // period of the even turning; 0: not known yet
  int since_search_ = 0;
  bool locked_ = false;
  double last_even_s_ = 0.0;  // time of the last scan
};

}  // namespace fusion_slam
