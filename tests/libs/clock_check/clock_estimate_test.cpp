#include "libs/clock_check/clock_estimate.hpp"

#include <random>

#include <gtest/gtest.h>

#include "libs/clock_check/clock_pong.hpp"

namespace fusion_slam {
namespace {

// The true offset is within the uncertainty, whatever the delays to and fro.
TEST(ClockEstimate, IsWithinItsUncertainty) {
  std::mt19937 rng(3);
  for (int trial = 0; trial < 200; ++trial) {
    const std::int64_t offset_us = static_cast<std::int64_t>(rng() % 20'000'000) - 10'000'000;
    std::vector<ClockSample> samples;
    for (std::int64_t i = 0; i < 20; ++i) {
      const std::int64_t there = rng() % 5000, back = rng() % 50'000;
      samples.push_back({i * 100'000, i * 100'000 + there + offset_us, i * 100'000 + there + back});
    }
    const ClockEstimate estimate = estimate_clock(samples);
    EXPECT_LE(std::abs(estimate.offset_ms - 1e-3 * static_cast<double>(offset_us)),
              estimate.uncertainty_ms + 1e-9);
    EXPECT_LE(estimate.uncertainty_ms, 0.5 * estimate.round_trip_ms_median + 1e-9);
    EXPECT_LE(estimate.round_trip_ms_median, estimate.round_trip_ms_max);
  }
}

TEST(ClockEstimate, OfNothingIsNothing) {
  EXPECT_EQ(estimate_clock({}).uncertainty_ms, 0.0);
  EXPECT_EQ(estimate_clock({{10, 5, 9}}).round_trip_ms_max, 0.0) << "answered before it was asked";
}

TEST(ClockPong, AMailboxAnswersAnother) {
  const std::string url = "memq://";
  Mailbox mailbox(url);
  answer_clock_pings(mailbox, "me");
  const auto replies = ask_clocks(mailbox, "asker", 5, 10);
  ASSERT_EQ(replies.count("me"), 1U);
  EXPECT_EQ(replies.at("me").answered, 5);
  EXPECT_LE(std::abs(replies.at("me").clock.offset_ms),
            replies.at("me").clock.uncertainty_ms + 0.002);
}

}  // namespace
}  // namespace fusion_slam
