#include "libs/bus/latency.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(Latency, PercentilesAgreeWithSorting) {
  std::mt19937 rng(5);
  std::lognormal_distribution<double> latency_us(8.0, 1.5);
  LatencyHistogram histogram;
  std::vector<double> all;
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(std::max(1.0, latency_us(rng)));
    histogram.add(all.back());
  }
  std::sort(all.begin(), all.end());
  for (const double fraction : {0.01, 0.5, 0.95, 0.99}) {
    const double exact_ms = all[static_cast<std::size_t>(fraction * 20'000)] / 1000.0;
    EXPECT_NEAR(histogram.percentile_ms(fraction) / exact_ms, 1.0, 0.03) << fraction;
  }
}

TEST(Latency, EmptyIsZeroAndExtremesAreClamped) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.percentile_ms(0.5), 0.0);
  histogram.add(-5.0);
  histogram.add(1e15);
  EXPECT_GT(histogram.percentile_ms(0.99), 900'000.0);
}

}  // namespace
}  // namespace fusion_slam
