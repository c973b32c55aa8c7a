#include <gtest/gtest.h>

#include "libs/localization/odometry_track.hpp"
#include "libs/localization/scan_memory.hpp"

namespace fusion_slam {
namespace {

TEST(OdometryTrack, InterpolatesAndNeverExtrapolates) {
  OdometryTrack track;
  EXPECT_FALSE(track.at(5));
  track.add(1'000'000, from_xyz_rpy(0, 0, 0, 0, 0, 0));
  track.add(1'200'000, from_xyz_rpy(1, 0, 0, 0, 0, 0.2));
  const auto middle = track.at(1'100'000);
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->translation().x(), 0.5, 1e-12);
  EXPECT_NEAR(to_se2(*middle).yaw, 0.1, 1e-9);
  EXPECT_TRUE(track.at(1'200'000));
  EXPECT_FALSE(track.at(999'999));
  EXPECT_FALSE(track.at(1'200'001));
  EXPECT_TRUE(track.reaches(1'200'000));
  EXPECT_FALSE(track.reaches(1'200'001));
  track.add(2'000'000, from_xyz_rpy(2, 0, 0, 0, 0, 0));
  EXPECT_FALSE(track.at(1'500'000));  // a gap is no trajectory
  track.clear();
  EXPECT_FALSE(track.at(1'100'000));
}

TEST(ScanMemory, KeepsTheLatestWay) {
  LocalizerConfig config;
  config.memory_m = 1.0;
  ScanMemory memory(config);
  EXPECT_TRUE(memory.points_base().empty());
  // One point of the world, at x = 5, seen while driving along x.
  for (int i = 0; i < 10; ++i)
    memory.add(i * 100'000, SE2{0.3 * i, 0, 0}, Points{{5.0 - 0.3 * i, 0.0}});
  EXPECT_EQ(memory.n_scans(), 4U);  // 0, 0.3, 0.6 and 0.9 m ago
  for (const auto& p : memory.points_base()) EXPECT_NEAR(p.x(), 5.0 - 2.7, 1e-9);
  memory.add(100'000'000, SE2{2.7, 0, 0}, Points{{1.0, 0.0}});  // long after
  EXPECT_EQ(memory.n_scans(), 1U);
}

}  // namespace
}  // namespace fusion_slam
