// Stamps of a computer that was busy: the scanner turns evenly all the same.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "services/lidar_mapper/scan_clock.hpp"

namespace fusion_slam {
namespace {

constexpr double kPeriodS = 0.2134;

struct Rest {
  double dt_rms_s = 0.0;    // of the interval against the truth
  double time_rms_s = 0.0;  // of the time of measurement, its mean taken out
  double mean_late_s = 0.0;
};

// `stamp_of(t)`: what the computer writes for a scan at t; one scan in `drop_one_in` is lost.
template <class StampOf>
Rest follow(const StampOf& stamp_of, int drop_one_in, double nominal_hz) {
  std::mt19937 rng(3);
  ScanClock clock(nominal_hz);
  double last_t = 0.0, dt2 = 0.0, sum = 0.0, sum2 = 0.0, late = 0.0;
  int n = 0;
  for (int k = 0; k < 1500; ++k) {
    if (k > 0 && rng() % static_cast<unsigned>(drop_one_in) == 0) continue;
    const double t = 100.0 + k * kPeriodS;
    const auto stamp_us = static_cast<std::int64_t>(std::llround(stamp_of(t) * 1e6));
    const auto interval = clock.advance(stamp_us);
    if (k > 200) {
      const double e = interval.dt_s - (t - last_t);
      const double measured = static_cast<double>(stamp_us) * 1e-6 - interval.late_s - t;
      dt2 += e * e, sum += measured, sum2 += measured * measured, late += interval.late_s;
      ++n;
    }
    last_t = t;
  }
  return {std::sqrt(dt2 / n), std::sqrt(sum2 / n - sum * sum / n / n), late / n};
}

TEST(ScanClockJitter, HalfAPeriodOfJitterBecomesAFewMilliseconds) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> busy(0.0, 0.5 * kPeriodS);
  for (const double nominal_hz : {5.0, 4.686, 10.0}) {
    const Rest rest = follow([&](double t) { return t + busy(rng); }, 30, nominal_hz);
    EXPECT_LT(rest.time_rms_s, 0.012) << nominal_hz;  // of 31 ms
    EXPECT_LT(rest.dt_rms_s, 0.016) << nominal_hz;    // of 44 ms
    EXPECT_NEAR(rest.mean_late_s, 0.0, 0.004) << nominal_hz;
  }
}

TEST(ScanClockJitter, StampsRoundedTo10MsLoseTheirRounding) {
  const Rest rest = follow([](double t) { return std::floor(t * 100.0) / 100.0; }, 50, 5.0);
  EXPECT_LT(rest.time_rms_s, 0.001);
  EXPECT_LT(rest.dt_rms_s, 0.0012);
}

TEST(ScanClockJitter, GoodStampsStayAsTheyAre) {
  const Rest rest = follow([](double t) { return t; }, 20, 5.0);
  EXPECT_LT(rest.time_rms_s, 1e-5);
  EXPECT_LT(rest.dt_rms_s, 1e-5);
}

// Stamps without any order can't be explained; they are taken as they are.
TEST(ScanClockJitter, WhereThereIsNoTurningNothingIsInvented) {
  std::mt19937 rng(1);
  std::exponential_distribution<double> gap(5.0);
  ScanClock clock(5.0);
  double t = 0.0;
  int locked = 0;
  for (int i = 0; i < 500; ++i) {
    t += 0.05 + gap(rng);
    const auto interval = clock.advance(static_cast<std::int64_t>(t * 1e6));
    locked += interval.late_s != 0.0 ? 1 : 0;
    EXPECT_LT(std::abs(interval.late_s), 0.2);
  }
  EXPECT_LT(locked, 100);
}

// A scanner whose rate wanders (an RPLidar's motor) is followed.
TEST(ScanClockJitter, AWanderingRateIsFollowed) {
  ScanClock clock(5.5);
  double t = 0.0, worst_s = 0.0;
  for (int i = 0; i < 600; ++i) {
    const double dt = 0.18 * (1.0 + 0.03 * std::sin(0.02 * i));
    t += dt;
    const auto interval = clock.advance(static_cast<std::int64_t>(std::llround(t * 1e6)));
    if (i > 0) worst_s = std::max(worst_s, std::abs(interval.dt_s - dt));
    EXPECT_LT(std::abs(interval.late_s), 0.09);
  }
  EXPECT_LT(worst_s, 0.09);
}

}  // namespace
}  // namespace fusion_slam
