#include <gtest/gtest.h>

#include "services/visual_odometry/visual_odometry.hpp"
#include "tests/services/visual_odometry/rendered_wall.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kFrame_us = 33'333;
const SE3 kMounting = from_xyz_rpy(0.1, 0.0, 0.5, -1.5707963, 0.0, -1.5707963);

class Tracking : public testing::Test {
 protected:
  TrackingResult show(int step) {
    ++n_frames_;
    return odometry_.track(wall_.see(camera_, walk(step), n_frames_ * kFrame_us));
  }
  TrackingResult show_blank() {
    ++n_frames_;
    return odometry_.track(blank(camera_, n_frames_ * kFrame_us));
  }
  // What odom should say at this step: base as seen from where base was at step 0.
  static SE3 truth(int step) {
    return kMounting * walk(0).inverse() * walk(step) * kMounting.inverse();
  }

  CameraModel camera_;
  RenderedWall wall_;
  VisualOdometry odometry_{camera_, robot_with(kMounting)};
  std::int64_t n_frames_ = 0;
};

TEST_F(Tracking, FollowsACameraAlongAWall) {
  std::int64_t previous_id = 0;
  SE3 T_odom_keyframe = SE3::Identity();
  for (int step = 0; step < 60; ++step) {
    const TrackingResult result = show(step);
    ASSERT_EQ(result.state, TrackingState::kOk) << step << ": " << result.reason;
    const Vector6d error = local(truth(step), result.T_odom_base);
    ASSERT_LT(error.head<3>().norm(), 0.015) << step;
    ASSERT_LT(error.tail<3>().norm(), 0.015) << step;
    if (result.keyframe) {
      EXPECT_EQ(result.keyframe->id, previous_id + 1);
      EXPECT_EQ(result.keyframe->previous_id, previous_id);
      // Local mapping has moved the previous keyframe a little since.
      const SE3 composed = T_odom_keyframe * result.keyframe->T_previous_base;
      EXPECT_LT(local(composed, result.T_odom_base).norm(), 0.01);
      EXPECT_GT(result.keyframe->features.size(), 500U);
      previous_id = result.keyframe->id;
      T_odom_keyframe = result.keyframe->T_odom_base;
    }
    EXPECT_EQ(result.reference_id, previous_id);
    EXPECT_LT(local(T_odom_keyframe * result.T_reference_base, result.T_odom_base).norm(), 0.01);
    EXPECT_EQ(result.fix_utime_us, result.utime_us);
  }
  EXPECT_GE(previous_id, 4);
  EXPECT_LE(previous_id, 30);
}

TEST_F(Tracking, GoesOnWhenTheClockIsSetBack) {
  for (int step = 0; step < 45; ++step) ASSERT_EQ(show(step).state, TrackingState::kOk) << step;
  n_frames_ -= 40;
  for (int step = 45; step < 60; ++step) {
    const TrackingResult result = show(step);
    ASSERT_EQ(result.state, TrackingState::kOk) << step << ": " << result.reason;
    EXPECT_LT(local(truth(step), result.T_odom_base).norm(), 0.03) << step;
  }
}

// A power cut: the journal has lost the last keyframe, which others know.
TEST_F(Tracking, GivesNoIdTwiceWhenTheLastKeyframeIsForgotten) {
  std::vector<Keyframe> keyframes;
  int step = 0;
  for (; step < 60 && keyframes.size() < 4; ++step)
    if (const TrackingResult result = show(step); result.keyframe)
      keyframes.push_back(*result.keyframe);
  ASSERT_EQ(keyframes.size(), 4U);
  keyframes.pop_back();
  VisualOdometry again(camera_, robot_with(kMounting));
  again.resume(keyframes, 1001);
  for (const int end = step + 40; step < end; ++step) {
    const TrackingResult result =
        again.track(wall_.see(camera_, walk(step), (step + 1) * kFrame_us));
    if (!result.keyframe) continue;
    EXPECT_EQ(result.keyframe->id, 1001);
    EXPECT_EQ(result.keyframe->previous_id, 3);
    const SE3 hung = keyframes.back().T_odom_base * result.keyframe->T_previous_base;
    EXPECT_LT(local(truth(step), hung).norm(), 0.05);
    return;
  }
  FAIL() << "no keyframe in 40 frames";
}

TEST_F(Tracking, StandingStillMakesNoKeyframes) {
  ASSERT_TRUE(show(0).keyframe);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(show(0).keyframe);
}

TEST_F(Tracking, SaysLostAndFindsItsWayBack) {
  for (int step = 0; step < 15; ++step) show(step);
  for (int i = 0; i < 5; ++i) {
    const TrackingResult result = show_blank();
    EXPECT_EQ(result.state, TrackingState::kLost);
    EXPECT_FALSE(result.reason.empty());
    EXPECT_LT(result.fix_utime_us, result.utime_us);
  }
  // 0.1 m and 0.03 rad from the last pose: only descriptors can tell.
  const TrackingResult back = show(5);
  EXPECT_EQ(back.state, TrackingState::kOk) << back.reason;
  EXPECT_LT(local(truth(5), back.T_odom_base).norm(), 0.03);
}

TEST_F(Tracking, StartsANewSegmentWhereItWasLost) {
  for (int step = 0; step < 5; ++step) show(step);
  const TrackingResult before = show(5);
  const RenderedWall elsewhere(99);
  TrackingResult result;
  for (int i = 0; i < 20; ++i) {
    result = odometry_.track(elsewhere.see(camera_, walk(5), ++n_frames_ * kFrame_us));
    if (result.keyframe) break;
    EXPECT_EQ(result.state, TrackingState::kLost);
  }
  ASSERT_TRUE(result.keyframe);
  EXPECT_EQ(result.keyframe->previous_id, 0);
  EXPECT_EQ(result.keyframe->id, before.reference_id + 1);
  EXPECT_EQ(result.state, TrackingState::kWeak);
  EXPECT_LT(local(before.T_odom_base, result.T_odom_base).norm(), 0.005);
  EXPECT_GT(result.covariance(0, 0), 0.1);
  result = odometry_.track(elsewhere.see(camera_, walk(6), ++n_frames_ * kFrame_us));
  EXPECT_EQ(result.state, TrackingState::kOk);
}

// A strip of the picture shows the old wall from elsewhere, all else is new: with the LiDAR's word
// against it that is no pose, however many features the strip has.
TEST_F(Tracking, AFewOfManyFeaturesDoNotOutvoteTheLidar) {
  VisualOdometryConfig config;
  config.disagree_m = 0.05;
  const RenderedWall elsewhere(99);
  const SE3 T_moved = walk(6) * from_xyz_rpy(0.08, 0, 0, 0, 0, 0);
  for (const bool lidar : {false, true}) {
    VisualOdometry odometry(camera_, robot_with(kMounting), config);
    for (int step = 0; step < 6; ++step)
      odometry.track(wall_.see(camera_, walk(step), (step + 1) * kFrame_us));
    for (int step = 0; lidar && step < 8; ++step)
      odometry.add_lidar_pose((step + 1) * kFrame_us, truth(step));
    RgbdFrame frame = elsewhere.see(camera_, walk(6), 7 * kFrame_us);
    const RgbdFrame old = wall_.see(camera_, T_moved, 7 * kFrame_us);
    const cv::Rect strip(0, 180, camera_.width_px, 120);
    old.colour_bgr(strip).copyTo(frame.colour_bgr(strip));
    old.depth_mm(strip).copyTo(frame.depth_mm(strip));
    const TrackingResult result = odometry.track(frame);
    if (lidar) {
      EXPECT_EQ(result.state, TrackingState::kLost);
      EXPECT_LT(local(truth(6), result.T_odom_base).norm(), 0.01) << "the LiDAR bridges";
    } else {
      EXPECT_GE(result.n_matched, config.min_inliers_ok);  // the trap is one
      EXPECT_GT(local(truth(6), result.T_odom_base).norm(), 0.05);
    }
  }
}

TEST_F(Tracking, BadFramesAreRefusedAndChangeNothing) {
  show(0);
  const TrackingResult good = show(1);
  RgbdFrame late = wall_.see(camera_, walk(2), kFrame_us);
  EXPECT_EQ(odometry_.track(late).state, TrackingState::kUnknown);
  RgbdFrame small = wall_.see(camera_, walk(2), 100 * kFrame_us);
  small.depth_mm = small.depth_mm(cv::Rect(0, 0, 320, 240));
  EXPECT_EQ(odometry_.track(small).state, TrackingState::kUnknown);
  EXPECT_EQ(odometry_.track({}).reason, "empty image");
  const TrackingResult next = show(2);
  EXPECT_EQ(next.state, TrackingState::kOk);
  EXPECT_EQ(next.reference_id, good.reference_id);
}

TEST_F(Tracking, ResetStartsANewSegment) {
  show(0);
  odometry_.reset();
  const TrackingResult result = show(1);
  ASSERT_TRUE(result.keyframe);
  EXPECT_EQ(result.keyframe->id, 2);
  EXPECT_EQ(result.keyframe->previous_id, 0);
}

TEST_F(Tracking, NothingToSeeIsLostFromTheStart) {
  const TrackingResult result = show_blank();
  EXPECT_EQ(result.state, TrackingState::kLost);
  EXPECT_EQ(result.reference_id, 0);
  EXPECT_EQ(show(0).state, TrackingState::kOk);
}

}  // namespace
}  // namespace fusion_slam
