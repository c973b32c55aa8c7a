#include "services/pose_graph/pose_track.hpp"

#include <gtest/gtest.h>

#include "services/pose_graph/clock_watch.hpp"

namespace fusion_slam {
namespace {

TrackPose pose(std::int64_t utime_us, double x, std::int64_t reference, double reference_x) {
  TrackPose p;
  p.utime_us = utime_us;
  p.T_odom_base = from_xyz_rpy(x, 0, 0, 0, 0, 0);
  p.reference = {NodeKind::kLidar, reference};
  p.T_reference_base = from_xyz_rpy(x - reference_x, 0, 0, 0, 0, 0);
  return p;
}

TEST(PoseTrack, InterpolatesAndSaysHowFar) {
  PoseTrack track(500'000, 60'000'000);
  track.add(pose(100'000, 1.0, 7, 0.5));
  track.add(pose(200'000, 2.0, 8, 2.0));
  const auto seen = track.at(150'000);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->pose.reference.id, 7);
  EXPECT_NEAR(seen->pose.T_odom_base.translation().x(), 1.5, 1e-12);
  EXPECT_NEAR(seen->pose.T_reference_base.translation().x(), 1.0, 1e-12);
  EXPECT_EQ(seen->gap_us, 100'000);
  EXPECT_EQ(track.at(200'000)->gap_us, 0);
  EXPECT_EQ(track.at(200'000)->pose.reference.id, 8);
}

TEST(PoseTrack, ForgetsTimesThatComeAgain) {
  PoseTrack track(500'000, 60'000'000);
  for (int i = 1; i <= 20; ++i) track.add(pose(i * 100'000, i, 1, 0.0));
  track.forget_from(1'000'000);
  EXPECT_FALSE(track.reaches(1'000'000));
  EXPECT_TRUE(track.at(850'000));
  track.add(pose(1'000'000, 21.0, 1, 0.0));
  track.add(pose(1'100'000, 22.0, 1, 0.0));
  EXPECT_FALSE(track.at(950'000)) << "between the two there is no motion";
  EXPECT_NEAR(track.at(1'050'000)->pose.T_odom_base.translation().x(), 21.5, 1e-12);
}

TEST(ClockWatch, TellsAClockThatWasSetBackFromALateMessage) {
  ClockWatch clock;
  EXPECT_FALSE(clock.was_set_back(1, 50'000'000));
  EXPECT_FALSE(clock.was_set_back(3, 52'000'000));
  EXPECT_FALSE(clock.was_set_back(2, 45'000'000)) << "late";
  EXPECT_FALSE(clock.was_set_back(4, 51'500'000)) << "jitter";
  EXPECT_TRUE(clock.was_set_back(5, 42'000'000));
  EXPECT_FALSE(clock.was_set_back(6, 42'100'000));
  EXPECT_FALSE(clock.was_set_back(1, 43'000'000)) << "started again";
  EXPECT_TRUE(clock.was_set_back(2, 33'000'000));
}

// A process that hung while the tracker was started again: the new one's messages and, repaired,
// the old one's come in any order.
TEST(ClockWatch, WhatThePublisherBeforeSaidIsLate) {
  ClockWatch clock;
  EXPECT_FALSE(clock.was_set_back(75, 15'000'000));
  EXPECT_FALSE(clock.was_set_back(1, 26'000'000));
  EXPECT_FALSE(clock.was_set_back(76, 19'200'000));
  EXPECT_FALSE(clock.was_set_back(2, 26'200'000));
  EXPECT_FALSE(clock.was_set_back(77, 19'400'000));
  EXPECT_FALSE(clock.was_set_back(3, 40'000'000));
  EXPECT_TRUE(clock.was_set_back(4, 30'200'000));
}

TEST(PoseTrack, NeitherExtrapolatesNorBridges) {
  PoseTrack track(500'000, 60'000'000);
  track.add(pose(1'000'000, 1.0, 1, 1.0));
  track.add(pose(1'600'000, 2.0, 1, 1.0));  // too long a gap
  track.mark_break();
  track.add(pose(1'700'000, 9.0, 2, 9.0));
  EXPECT_FALSE(track.at(900'000));
  EXPECT_FALSE(track.at(1'300'000));
  EXPECT_FALSE(track.at(1'650'000));
  EXPECT_FALSE(track.at(1'800'000));
  EXPECT_FALSE(track.motion(1'600'000, 1'700'000));
  EXPECT_TRUE(track.reaches(1'700'000));
  EXPECT_FALSE(track.reaches(1'700'001));
}

TEST(PoseTrack, ForgetsWhatIsOld) {
  PoseTrack track(500'000, 1'000'000);
  for (int i = 0; i < 100; ++i) track.add(pose(i * 100'000, i, 1, 0.0));
  EXPECT_FALSE(track.at(8'000'000));
  EXPECT_TRUE(track.at(9'500'000));
  const auto motion = track.motion(9'000'000, 9'850'000);
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->translation().x(), 8.5, 1e-9);
}

}  // namespace
}  // namespace fusion_slam
