#include "libs/datasets/hokuyo.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "libs/datasets/wheel_odometry.hpp"

namespace fusion_slam {
namespace {

std::string line(long time_us, int left, int right, int range_mm) {
  std::string text =
      std::to_string(time_us) + " 14710.5 " + std::to_string(left) + " " + std::to_string(right);
  for (int i = 4; i < 24; ++i) text += " 0";
  text += " ";
  for (int i = 0; i < 683; ++i) text += " " + std::to_string(range_mm + i);
  return text + "\n";
}

TEST(Hokuyo, Golden) {
  const HokuyoLog log = parse_mines_hokuyo(line(1000, 5, -7, 1500) + line(2000, 6, -6, 0));
  ASSERT_EQ(log.records.size(), 2u);
  const HokuyoRecord& r = log.records[0];
  EXPECT_EQ(r.scan.utime_us, 1000);
  EXPECT_EQ(r.left_ticks, 5);
  EXPECT_EQ(r.right_ticks, -7);
  ASSERT_EQ(r.scan.ranges_m.size(), 682u);
  EXPECT_FLOAT_EQ(r.scan.ranges_m[0], 1.5F);
  EXPECT_FLOAT_EQ(r.scan.ranges_m[681], 2.181F);
  EXPECT_NEAR(r.scan.rad0 + 340 * r.scan.radstep, 0.0, 1e-12);  // step 384 looks forward
  EXPECT_EQ(log.records[1].scan.ranges_m[19], 0.0F);            // an error code
  EXPECT_FLOAT_EQ(log.records[1].scan.ranges_m[20], 0.02F);
}

TEST(Hokuyo, DamageIsCounted) {
  const HokuyoLog log = parse_mines_hokuyo(line(1000, 0, 0, 99) + "1 2 3\n" + line(900, 0, 0, 99) +
                                           "x" + line(3000, 0, 0, 99) + line(4000, 0, 0, 99));
  EXPECT_EQ(log.records.size(), 2u);
  EXPECT_EQ(log.skipped.reasons().at("fewer than 706 numbers").first_place, 2);
  EXPECT_EQ(log.skipped.reasons().at("time does not increase").first_place, 3);
  EXPECT_EQ(log.skipped.reasons().at("not an integer").first_place, 4);
}

TEST(WheelOdometry, ArcsAgreeWithManySmallSteps) {
  const WheelGeometry wheels{0.001, 0.3};
  const SE2 whole = wheel_motion(wheels, {0, 0, 0}, {1, 1000, 1400});
  SE2 small;
  for (int i = 0; i < 200; ++i)
    small = small * wheel_motion(wheels, {0, 5 * i, 7 * i}, {0, 5 * i + 5, 7 * i + 7});
  EXPECT_NEAR(whole.x, small.x, 1e-9);
  EXPECT_NEAR(whole.y, small.y, 1e-9);
  EXPECT_NEAR(whole.yaw, small.yaw, 1e-9);
  EXPECT_NEAR(whole.yaw, 0.4 / 0.3, 1e-12);
  EXPECT_GT(whole.y, 0.0);  // the right wheel runs ahead: to the left
  const SE2 straight = wheel_motion(wheels, {0, 10, 10}, {1, 110, 110});
  EXPECT_NEAR(straight.x, 0.1, 1e-12);
  EXPECT_EQ(straight.yaw, 0.0);
}

}  // namespace
}  // namespace fusion_slam
