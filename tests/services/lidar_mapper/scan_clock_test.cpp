#include "services/lidar_mapper/scan_clock.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(ScanClock, LearnsThePeriodAndDoubtsWhatNoSensorDoes) {
  ScanClock clock(10.0);
  std::int64_t t = 5'000'000;
  EXPECT_FALSE(clock.advance(t).trusted);  // the first has no interval
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(clock.advance(t += 200'000).trusted);
  EXPECT_NEAR(clock.period_s(), 0.2, 1e-9);  // not the 10 Hz that the model says
  EXPECT_NEAR(clock.advance(t += 110'000).dt_s, 0.11, 1e-9);
  for (const std::int64_t jump : {0, 1'000, -70'000, 20'000}) {
    const auto interval = clock.advance(t += jump);
    EXPECT_FALSE(interval.trusted) << jump;
    EXPECT_GT(interval.dt_s, 0.05) << jump;
  }
  EXPECT_NEAR(clock.advance(t += 2'200'000).dt_s, 2.2, 0.2);  // whole turns, after such stamps
}

TEST(ScanClock, ASenselessNominalRateIsReplaced) {
  EXPECT_NEAR(ScanClock(0.0).period_s(), 0.1, 1e-9);
  EXPECT_NEAR(ScanClock(-3.0).period_s(), 0.1, 1e-9);
  EXPECT_NEAR(ScanClock(5.0).period_s(), 0.2, 1e-9);
}

}  // namespace
}  // namespace fusion_slam
