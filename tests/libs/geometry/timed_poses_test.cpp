#include "libs/geometry/timed_poses.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

SE3 at_x(double x_m) { return from_xyz_rpy(x_m, 0.0, 0.0, 0.0, 0.0, 0.0); }

TEST(TimedPoses, BetweenTwoAsTheirLineSays) {
  const TimedPoses poses{{1000, at_x(1.0)}, {1400, at_x(3.0)}, {5000, at_x(9.0)}};
  EXPECT_DOUBLE_EQ(pose_at(poses, 1000, 400)->translation().x(), 1.0);
  EXPECT_DOUBLE_EQ(pose_at(poses, 1100, 400)->translation().x(), 1.5);
  EXPECT_DOUBLE_EQ(pose_at(poses, 5000, 400)->translation().x(), 9.0);  // however far the others
  EXPECT_FALSE(pose_at(poses, 1500, 400));
  EXPECT_TRUE(pose_at(poses, 1500, 3600));
  EXPECT_FALSE(pose_at(poses, 999, 400));
  EXPECT_FALSE(pose_at(poses, 5001, 400));
  EXPECT_FALSE(pose_at({}, 0, 400));
}

TEST(TimedPoses, TimesOfHostileMessages) {
  const std::int64_t least = std::numeric_limits<std::int64_t>::min();
  const std::int64_t most = std::numeric_limits<std::int64_t>::max();
  EXPECT_FALSE(pose_at({{least, at_x(0.0)}, {most, at_x(1.0)}}, 0, most));
}

}  // namespace
}  // namespace fusion_slam
