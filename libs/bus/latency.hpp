// Percentiles of many latencies in fixed memory: logarithmic buckets, each 2.5 % wide, 1 us to 1000
// s.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace fusion_slam {

class LatencyHistogram {
 public:
  void add(double latency_us) {
    const double clamped = std::min(std::max(latency_us, 1.0), 1e9);
    const auto bucket = static_cast<std::size_t>(std::log(clamped) / kLogStep);
    ++counts_[std::min(bucket, counts_.size() - 1)];
    ++total_;
  }

  // Latency in ms that `fraction` (0..1) of all stay below, to the width of a bucket; 0 when
  // nothing was added.
  double percentile_ms(double fraction) const {
    const auto wanted =
        static_cast<std::int64_t>(std::ceil(fraction * static_cast<double>(total_)));
    std::int64_t seen = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      seen += counts_[i];
      if (seen >= wanted && seen > 0)
        return std::exp((static_cast<double>(i) + 0.5) * kLogStep) / 1000.0;
    }
    return 0.0;
  }

  std::int64_t count() const { return total_; }

 private:
  static constexpr double kLogStep = 0.025;
  std::array<std::int64_t, 840> counts_{};
  std::int64_t total_ = 0;
};

}  // namespace fusion_slam
