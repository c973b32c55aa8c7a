#include "libs/clock_check/clock_estimate.hpp"

#include <algorithm>

namespace fusion_slam {

ClockEstimate estimate_clock(const std::vector<ClockSample>& samples) {
  std::vector<ClockSample> good;
  for (const ClockSample& sample : samples)
    if (sample.received_us >= sample.sent_us) good.push_back(sample);
  if (good.empty()) return {};
  const auto round_trip = [](const ClockSample& s) { return s.received_us - s.sent_us; };
  std::sort(good.begin(), good.end(), [&](const ClockSample& a, const ClockSample& b) {
    return round_trip(a) < round_trip(b);
  });
  const ClockSample& best = good.front();
  ClockEstimate estimate;
  const double half_us = 0.5 * static_cast<double>(round_trip(best));
  estimate.offset_ms = 1e-3 * (static_cast<double>(best.there_us - best.sent_us) - half_us);
  estimate.uncertainty_ms = 1e-3 * half_us;
  estimate.round_trip_ms_median = 1e-3 * static_cast<double>(round_trip(good[good.size() / 2]));
  estimate.round_trip_ms_max = 1e-3 * static_cast<double>(round_trip(good.back()));
  return estimate;
}

}  // namespace fusion_slam
