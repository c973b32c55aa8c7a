// A process that begins again has its own last keyframes, out of the journal.
#include <gtest/gtest.h>

#include "services/visual_odometry/visual_odometry.hpp"
#include "tests/services/visual_odometry/made_up_map.hpp"
#include "tests/services/visual_odometry/rendered_wall.hpp"
#include "tests/services/visual_odometry/small_camera.hpp"

namespace fusion_slam {
namespace {

constexpr int kSteps = 60;

class Resume : public testing::Test {
 protected:
  // The earlier process, once for all tests.
  static void SetUpTestSuite() {
    VisualOdometry first(small_camera(), robot(), small_config());
    const RenderedWall wall;
    keyframes_.clear();
    for (int step = 0; step < kSteps; ++step) {
      TrackingResult result =
          first.track(wall.see(small_camera(), walk(step), (step + 1) * kFrame_us));
      if (result.keyframe) keyframes_.push_back(std::move(*result.keyframe));
    }
  }
  static RobotModel robot() {
    return robot_with(from_xyz_rpy(0.1, 0.0, 0.5, -1.5707963, 0.0, -1.5707963));
  }
  TrackingResult show(VisualOdometry* odometry, int step) {
    ++n_frames_;
    return odometry->track(wall_.see(camera_, walk(step), n_frames_ * kFrame_us));
  }
  double off_m(const TrackingResult& result, int step) const {
    const SE3 T_truth =
        robot_.T_base_camera * walk(0).inverse() * walk(step) * robot_.T_base_camera.inverse();
    return local(T_truth, result.T_odom_base).head<3>().norm();
  }

  CameraModel camera_ = small_camera();
  VisualOdometryConfig config_ = small_config();
  RobotModel robot_ = robot();
  RenderedWall wall_;
  inline static std::vector<Keyframe> keyframes_;
  std::int64_t n_frames_ = kSteps;
};

TEST_F(Resume, GoesOnInTheSameFrameWithTheNextId) {
  ASSERT_GE(keyframes_.size(), 8U);
  VisualOdometry again(camera_, robot_, config_);
  again.resume(keyframes_);
  EXPECT_EQ(again.map().keyframes().size(), keyframes_.size());
  EXPECT_TRUE(consistent(again.map()));
  TrackingResult result = show(&again, kSteps);
  EXPECT_EQ(result.state, TrackingState::kOk) << result.reason;
  EXPECT_LT(off_m(result, kSteps), 0.05);
  std::int64_t expected_id = keyframes_.back().id + 1;
  for (int step = kSteps; step < kSteps + 30; ++step) {
    if (step > kSteps) result = show(&again, step);
    ASSERT_NE(result.state, TrackingState::kLost) << step << " " << result.reason;
    EXPECT_LT(off_m(result, step), 0.05) << step;
    if (!result.keyframe) continue;
    EXPECT_EQ(result.keyframe->id, expected_id);
    EXPECT_EQ(result.keyframe->previous_id, expected_id - 1);
    ++expected_id;
  }
  EXPECT_GT(expected_id, keyframes_.back().id + 2);
  EXPECT_TRUE(consistent(again.map()));
}

// Moved while nobody looked: back to where it had been before.
TEST_F(Resume, FindsAnOldPlaceAgain) {
  VisualOdometry again(camera_, robot_, config_);
  again.resume(keyframes_);
  const TrackingResult result = show(&again, 12);
  EXPECT_EQ(result.state, TrackingState::kOk) << result.reason;
  EXPECT_LT(off_m(result, 12), 0.05);
  ASSERT_TRUE(result.keyframe);
  EXPECT_EQ(result.keyframe->id, keyframes_.back().id + 1);
  EXPECT_GT(result.keyframe->previous_id, 0);
}

TEST_F(Resume, AnUnknownPlaceIsANewSegmentWithTheNextId) {
  VisualOdometry again(camera_, robot_, config_);
  again.resume(keyframes_);
  const RenderedWall elsewhere(99);
  TrackingResult result;
  for (int i = 0; i < 30 && !result.keyframe; ++i)
    result = again.track(elsewhere.see(camera_, walk(0), ++n_frames_ * kFrame_us));
  ASSERT_TRUE(result.keyframe);
  EXPECT_EQ(result.keyframe->id, keyframes_.back().id + 1);
  EXPECT_EQ(result.keyframe->previous_id, 0);
}

TEST_F(Resume, NothingToResumeIsAFirstStart) {
  VisualOdometry fresh(camera_, robot_, config_);
  fresh.resume({});
  const TrackingResult result = show(&fresh, 0);
  ASSERT_TRUE(result.keyframe);
  EXPECT_EQ(result.keyframe->id, 1);
}

}  // namespace
}  // namespace fusion_slam
