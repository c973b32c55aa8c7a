// When a frame was taken, in our time. The device stamps frames by its own clock, which starts
// anywhere and runs up to some 100 ppm fast or slow; frames reach us late by a varying time, never
// early. So a line below all (stamp, arrival - stamp) tells both: drift and offset. The line: the
// edge of the lower convex hull above the middle of the stamps (Zhang, Liu & Xia 2002, "Clock
// synchronization algorithms for network measurements": the least mean distance of all lines below
// the points). What stays is the shortest delay, which no clock can see: calibration finds it.
#pragma once

#include <cstdint>
#include <deque>
#include <utility>

namespace fusion_slam {

// One thread.
class DeviceClock {
 public:
  // A frame stamped device_us reached us at host_us (a clock that does not jump). Returns when it
  // was taken, in the host's clock: never after its arrival. A stamp of 0 (devices without a clock)
  // gives the arrival. Stamps may be up to 0.5 s out of order (two streams).
  std::int64_t add(std::int64_t device_us, std::int64_t host_us);

  double drift_ppm() const { return 1e6 * slope_; }  // how much faster the host's clock is
  int restarts() const { return restarts_; }         // the device's clock jumped

 private:
  struct Point {
    double x_us;  // stamp after origin_us_
    double y_us;  // arrival - stamp
  };
  void restart(std::int64_t device_us, std::int64_t host_us);
  void fit();
  double line(double x_us) const { return offset_us_ + slope_ * x_us; }

  bool started_ = false;
  std::int64_t origin_us_ = 0;  // stamp
  std::int64_t base_us_ = 0;    // arrival - stamp of the first frame
  double last_us_ = 0.0;        // newest stamp after origin_us_
  std::deque<Point> lowest_;    // of each window, oldest first; the last one is growing
  double window_begin_us_ = 0.0;
  int late_windows_ = 0;
  double slope_ = 0.0;
  double offset_us_ = 0.0;
  int restarts_ = 0;
};

}  // namespace fusion_slam
