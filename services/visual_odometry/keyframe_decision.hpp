// When a frame becomes a keyframe: when it brings information, never because time has passed.
#pragma once

#include "libs/geometry/pose.hpp"
#include "services/visual_odometry/config.hpp"

namespace fusion_slam {

enum class KeyframeReason { kNone, kFewInliers, kParallax, kRotation };

struct KeyframeEvidence {
  SE3 T_keyframe_camera = SE3::Identity();  // motion since the last keyframe
  double median_depth_m = 0.0;              // of the features of this frame
  int n_inliers = 0;
  int n_inliers_at_keyframe = 0;  // in the first frame after the last keyframe
};

KeyframeReason decide_keyframe(const KeyframeEvidence& evidence,
                               const VisualOdometryConfig& config);

}  // namespace fusion_slam
