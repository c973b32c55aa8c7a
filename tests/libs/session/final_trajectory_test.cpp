#include "libs/session/final_trajectory.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

SE3 at_x(double x) { return from_xyz_rpy(x, 0, 0, 0, 0, 0); }
NodeId keyframe(std::int64_t id) { return {NodeKind::kKeyframe, id}; }
NodeId lidar(std::int64_t id) { return {NodeKind::kLidar, id}; }

TEST(FinalTrajectory, PosesMoveWithTheirNodes) {
  TrackedSession session;
  session.camera_utimes_us = {10, 20};
  session.visual[10] = {false, keyframe(1), at_x(0.1)};
  session.visual[20] = {false, keyframe(1), at_x(0.2)};
  session.T_map_nodes[keyframe(1)] = at_x(5.0);
  const auto poses = final_trajectory(session);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_NEAR(poses[1].T_map_base.translation().x(), 5.2, 1e-12);
}

TEST(FinalTrajectory, LostFramesAreBridgedOnlyBetweenScans) {
  TrackedSession session;
  session.T_map_nodes[lidar(1)] = at_x(0.0);
  session.lidar[100'000] = {false, lidar(1), at_x(1.0)};
  session.lidar[200'000] = {false, lidar(1), at_x(2.0)};
  session.lidar[300'000] = {true, {}, {}};
  session.lidar[900'000] = {false, lidar(1), at_x(9.0)};
  for (const std::int64_t t : {50'000, 150'000, 500'000, 950'000}) session.visual[t].lost = true;
  session.camera_utimes_us = {50'000, 150'000, 175'000, 500'000, 950'000};
  const auto poses = final_trajectory(session);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_TRUE(poses[0].bridged);
  EXPECT_EQ(poses[0].utime_us, 150'000);
  EXPECT_NEAR(poses[0].T_map_base.translation().x(), 1.5, 1e-12);
  EXPECT_NEAR(poses[1].T_map_base.translation().x(), 1.75, 1e-12);  // vision never said a word
}

TEST(FinalTrajectory, WithoutACameraItIsTheScans) {
  TrackedSession session;
  session.T_map_nodes[lidar(1)] = at_x(0.0);
  session.lidar[1] = {false, lidar(1), at_x(1.0)};
  session.lidar[2] = {false, lidar(2), at_x(1.0)};  // a node that GRAPH never had
  session.lidar[3] = {true, {}, {}};
  const auto poses = final_trajectory(session);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_FALSE(poses[0].bridged);
}

TEST(FinalTrajectory, TimesAsFarApartAsTheyCanBe) {
  constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
  TrackedSession session;
  session.T_map_nodes[lidar(1)] = at_x(0.0);
  session.lidar[kFirst] = {false, lidar(1), at_x(1.0)};
  session.lidar[kLast - 100] = {false, lidar(1), at_x(2.0)};
  session.lidar[kLast] = {false, lidar(1), at_x(3.0)};
  session.camera_utimes_us = {0, kLast - 50};
  const auto poses = final_trajectory(session);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_NEAR(poses[0].T_map_base.translation().x(), 2.5, 1e-12);
}

}  // namespace
}  // namespace fusion_slam
