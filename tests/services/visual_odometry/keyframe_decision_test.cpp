#include "services/visual_odometry/keyframe_decision.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

KeyframeReason decide(const SE3& motion, int inliers) {
  KeyframeEvidence evidence;
  evidence.T_keyframe_camera = motion;
  evidence.median_depth_m = 2.0;
  evidence.n_inliers = inliers;
  evidence.n_inliers_at_keyframe = 300;
  return decide_keyframe(evidence, {});
}

TEST(KeyframeDecision, ByInformation) {
  const SE3 a_little = from_xyz_rpy(0.05, 0, 0, 0, 0, 0);
  EXPECT_EQ(decide(a_little, 290), KeyframeReason::kNone);
  EXPECT_EQ(decide(a_little, 100), KeyframeReason::kFewInliers);
  EXPECT_EQ(decide(from_xyz_rpy(0.25, 0, 0, 0, 0, 0), 290), KeyframeReason::kParallax);
  EXPECT_EQ(decide(from_xyz_rpy(0, 0, 0, 0, 0, 0.3), 290), KeyframeReason::kRotation);
}

TEST(KeyframeDecision, NoneWhileStandingStillWhateverIsSeen) {
  EXPECT_EQ(decide(from_xyz_rpy(0.005, 0, 0, 0, 0, 0.005), 20), KeyframeReason::kNone);
}

}  // namespace
}  // namespace fusion_slam
