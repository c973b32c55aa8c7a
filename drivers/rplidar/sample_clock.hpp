// When a sample was measured. The device numbers no samples and has no clock on the wire; it
// measures evenly, and bytes reach us late by a varying time, never early. So the earliest arrival,
// sample for sample, tells the clock: the lower envelope of (arrival - number * period), which may
// rise slowly because neither clock is exact.
#pragma once

#include <cstdint>

namespace fusion_slam {

class SampleClock {
 public:
  explicit SampleClock(double period_s) : period_us_(period_s * 1e6) {}

  // Sample `number` (0, 1, 2 ...) can't have been measured after `latest_us`. Numbers in increasing
  // order.
  void bound(std::int64_t number, double latest_us);
  // After a loss of unknown length: what came before says nothing about what comes.
  void restart() { started_ = false; }
  // utime of a sample; 0 before the first bound().
  std::int64_t utime_us(std::int64_t number) const;

 private:
  double period_us_;
  bool started_ = false;
  double offset_us_ = 0.0;  // utime of sample 0
  std::int64_t last_number_ = 0;
  double lowest_us_ = 0.0;  // offset since window_begin_us_
  double window_begin_us_ = 0.0;
};

}  // namespace fusion_slam
