// Which colour image and which depth image belong together: two streams that need not expose at the
// same time, and lose frames each for itself. Pure; one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include <opencv2/core.hpp>

namespace fusion_slam {

struct TimedImage {
  std::int64_t utime_us = 0;
  cv::Mat image;
  std::int64_t device_us = 0;  // stamp of the device's clock; 0: none
};

struct FramePair {
  TimedImage colour;  // CV_8UC3, BGR
  TimedImage depth;   // CV_16UC1, mm
  std::int64_t error_us() const { return depth.utime_us - colour.utime_us; }
};

struct PairingCounters {
  std::int64_t pairs = 0;
  std::int64_t colour_alone = 0;
  std::int64_t depth_alone = 0;
  double sum_error_us = 0.0;  // of |error|
  std::int64_t largest_error_us = 0;
};

class FramePairer {
 public:
  // period_s: of the slower stream. Images up to half of it apart are a pair: then no other image
  // is nearer to either.
  explicit FramePairer(double period_s);

  // Images of each stream in the order of their time; one that is not later than the one before is
  // dropped. The pair that this image completes.
  std::optional<FramePair> add_colour(TimedImage image);
  std::optional<FramePair> add_depth(TimedImage image);

  const PairingCounters& counters() const { return counters_; }

 private:
  std::optional<FramePair> match();

  std::int64_t tolerance_us_;
  std::deque<TimedImage> colour_, depth_;  // one of them is empty after match()
  std::int64_t last_colour_us_ = INT64_MIN;
  std::int64_t last_depth_us_ = INT64_MIN;
  PairingCounters counters_;
};

}  // namespace fusion_slam
