// The even grid against a slow obvious reading of its rules; and the clock of the samples.
#include "drivers/rplidar/resample.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "drivers/rplidar/sample_clock.hpp"
#include "tests/drivers/rplidar/turns.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

Revolution turn_of(const std::vector<VirtualSample>& samples) {
  Revolution turn;
  turn.has_quality = true;
  for (std::size_t i = 0; i < samples.size(); ++i)
    turn.measurements.push_back({samples[i].angle_deg, samples[i].range_m, samples[i].quality,
                                 kBegin_us + static_cast<std::int64_t>(i) * 500});
  turn.period_s = static_cast<double>(samples.size()) * kPeriod_s;
  return turn;
}

// Of all measurements: the nearest before and the nearest behind the beam, going around.
double slow_range(const Revolution& turn, double beam_deg, double step_deg) {
  const Measurement* before = nullptr;
  const Measurement* behind = nullptr;
  double before_deg = 1e9;
  double behind_deg = 1e9;
  for (const Measurement& m : turn.measurements) {
    const double back = std::fmod(beam_deg - m.angle_deg + 720.0, 360.0);
    const double on = std::fmod(m.angle_deg - beam_deg + 720.0, 360.0);
    if (back < before_deg) before_deg = back, before = &m;
    if (on > 0.0 && on < behind_deg) behind_deg = on, behind = &m;
  }
  const double reach =
      1.5 * std::max(step_deg, 360.0 / static_cast<double>(turn.measurements.size()));
  if (std::min(before_deg, behind_deg) > reach) return 0.0;
  const double gap = before_deg + behind_deg;
  const double a = before->range_m;
  const double b = behind->range_m;
  const double steepest = std::tan(75.0 * M_PI / 180.0) * gap * M_PI / 180.0;
  if (a > 0.0 && b > 0.0 && gap <= 2.0 * reach && std::abs(a - b) < steepest * std::min(a, b))
    return (a * behind_deg + b * before_deg) / gap;
  return behind_deg < before_deg ? b : a;
}

TEST(Resample, IsWhatTheSlowRuleSays) {
  std::mt19937 random(3);
  std::uniform_real_distribution<> unit(0.0, 1.0);
  for (int run = 0; run < 20; ++run) {
    std::vector<VirtualSample> samples;
    const int n = 250 + static_cast<int>(random() % 200);
    double range_m = 2.0;
    for (int i = 0; i < n; ++i) {
      if (unit(random) < 0.1) range_m = 0.3 + 5.0 * unit(random);
      const double angle_deg = std::fmod(360.0 * i / n + 3.0 * unit(random), 360.0);
      if (unit(random) < 0.9) samples.push_back({angle_deg, unit(random) < 0.1 ? 0.0 : range_m, 9});
    }
    const Revolution turn = turn_of(samples);
    for (const double beam_period_s : {2.5e-4, 5e-4, 1e-3}) {
      const LaserScan scan = to_laser_scan(turn, beam_period_s);
      ASSERT_EQ(scan.ranges_m.size(),
                static_cast<std::size_t>(std::lround(turn.period_s / beam_period_s)));
      const double step_deg = 360.0 / static_cast<double>(scan.ranges_m.size());
      for (std::size_t i = 0; i < scan.ranges_m.size(); ++i)
        EXPECT_NEAR(scan.ranges_m[i], slow_range(turn, static_cast<double>(i) * step_deg, step_deg),
                    1e-5);
    }
  }
}

TEST(Resample, ClockwiseOfTheDeviceIsNegativeHere) {
  std::vector<VirtualSample> samples;
  for (int i = 0; i < 360; ++i)  // something near on the device's right, at 90 degrees clockwise
    samples.push_back({static_cast<double>(i), i > 85 && i < 95 ? 1.0 : 4.0, 20});
  const LaserScan scan = to_laser_scan(turn_of(samples), kPeriod_s);
  EXPECT_EQ(scan.utime_us, kBegin_us);
  EXPECT_LT(scan.radstep, 0.0);
  EXPECT_EQ(scan.intensities.size(), scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double angle_rad = scan.rad0 + static_cast<double>(i) * scan.radstep;
    const bool near = std::abs(angle_rad + M_PI / 2.0) < 4.5 * M_PI / 180.0;
    EXPECT_EQ(scan.ranges_m[i] < 2.0F, near) << i;
  }
}

TEST(Resample, AnEvenTurnIsUntouched) {
  const VirtualWorld room = virtual_room(1, 360);
  const LaserScan scan = to_laser_scan(turn_of(room.turns[0].samples), kPeriod_s);
  for (std::size_t i = 0; i < 360; ++i)
    EXPECT_FLOAT_EQ(scan.ranges_m[i], static_cast<float>(room.turns[0].samples[i].range_m));
}

TEST(Resample, ExtremeTurnsGiveBoundedScans) {
  std::vector<VirtualSample> one = {{10.0, 1.0, 1}};
  EXPECT_EQ(to_laser_scan(turn_of(one), kPeriod_s).ranges_m.size(), kFewestBeams);
  Revolution slow = turn_of(virtual_room(1, 360).turns[0].samples);
  slow.period_s = 1e6;
  EXPECT_EQ(to_laser_scan(slow, 1e-5).ranges_m.size(), kMostBeams);
}

// A wall stays a wall: end points of the resampled real sweeps lie where the measured ones lie.
TEST(Resample, RealSweepsKeepTheirShape) {
  FS_RECORDING(log, "lidar/lcm-maebot-empty/empty_environment.log");
  const VirtualWorld world = read_virtual_world(log);
  std::vector<double> distances_m;
  for (std::size_t t = 0; t < world.turns.size(); t += 20) {
    const Revolution turn = turn_of(world.turns[t].samples);
    const LaserScan scan = to_laser_scan(turn, kPeriod_s);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      if (scan.ranges_m[i] <= 0.0F) continue;
      const double angle = -(scan.rad0 + static_cast<double>(i) * scan.radstep);
      double nearest_m = 1e9;
      for (const Measurement& m : turn.measurements) {
        const double other = m.angle_deg * M_PI / 180.0;
        nearest_m =
            std::min(nearest_m,
                     std::hypot(scan.ranges_m[i] * std::cos(angle) - m.range_m * std::cos(other),
                                scan.ranges_m[i] * std::sin(angle) - m.range_m * std::sin(other)));
      }
      distances_m.push_back(nearest_m);
    }
  }
  std::sort(distances_m.begin(), distances_m.end());
  EXPECT_LT(distances_m[distances_m.size() / 2], 0.01);
  EXPECT_LT(distances_m[distances_m.size() * 95 / 100], 0.03);
}

TEST(SampleClock, TheEarliestArrivalsTellTheTime) {
  std::mt19937 random(5);
  std::exponential_distribution<> late_us(1.0 / 4000.0);  // 4 ms late on average
  const double true_period_us = 500.0 * (1.0 + 1e-4);     // the device's crystal
  SampleClock clock(500e-6);
  double worst_us = 0.0;
  for (std::int64_t n = 0; n < 20'000; ++n) {
    const double measured_us = 1e9 + static_cast<double>(n) * true_period_us;
    clock.bound(n, measured_us + late_us(random));
    const double error_us = static_cast<double>(clock.utime_us(n)) - measured_us;
    EXPECT_GE(error_us, -1.0) << "before it was measured";
    if (n > 200) worst_us = std::max(worst_us, error_us);
  }
  EXPECT_LT(worst_us, 1000.0);
}

TEST(SampleClock, CatchesUpAfterAnUnseenLoss) {
  SampleClock clock(500e-6);
  for (std::int64_t n = 0; n < 10'000; ++n) {
    const std::int64_t lost = n < 4'000 ? 0 : 60;  // samples that never came
    const double measured_us = 1e9 + static_cast<double>(n + lost) * 500.0;
    clock.bound(n, measured_us + static_cast<double>(n % 7) * 100.0);
    if (n >= 4'000 && n <= 6'500) continue;
    EXPECT_NEAR(static_cast<double>(clock.utime_us(n)), measured_us, 500.0) << n;
  }
}

TEST(SampleClock, WhatWaitedInABufferKeepsItsTime) {
  SampleClock clock(500e-6);
  for (std::int64_t n = 0; n < 20'000; ++n) {
    const double measured_us = 1e9 + static_cast<double>(n) * 500.0;
    // Nobody reads for 3 s, from sample 8000 to 14000.
    clock.bound(n, n < 8'000 || n > 14'000 ? measured_us + 100.0 : 1e9 + 14'000 * 500.0);
    EXPECT_NEAR(static_cast<double>(clock.utime_us(n)), measured_us + 100.0, 10'000.0) << n;
  }
}

TEST(SampleClock, StartsAnewAfterALoss) {
  SampleClock clock(500e-6);
  EXPECT_EQ(clock.utime_us(0), 0);
  clock.bound(0, 1e6);
  clock.bound(1, 1e6 + 100'000);
  EXPECT_LT(clock.utime_us(1), 1'001'000);
  clock.restart();
  clock.bound(2, 2e6);
  EXPECT_EQ(clock.utime_us(2), 2'000'000);
}

}  // namespace
}  // namespace fusion_slam
