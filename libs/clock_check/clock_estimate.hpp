// How far another machine's clock is off ours, from pings and their answers: the estimate of NTP
// (RFC 5905, section 8) with one time stamp there instead of two, and its clock filter: the answer
// that was fastest says most.
#pragma once

#include <cstdint>
#include <vector>

namespace fusion_slam {

struct ClockSample {
  std::int64_t sent_us = 0;      // our clock
  std::int64_t there_us = 0;     // its clock when it answered
  std::int64_t received_us = 0;  // our clock
};

struct ClockEstimate {
  double offset_ms = 0.0;       // its clock minus ours
  double uncertainty_ms = 0.0;  // the offset is certainly within this: half the fastest round trip
  double round_trip_ms_median = 0.0;
  double round_trip_ms_max = 0.0;
};

// Needs at least one sample; samples whose answer came before the question are ignored, and all
// zeros are returned when none is left.
ClockEstimate estimate_clock(const std::vector<ClockSample>& samples);

}  // namespace fusion_slam
