#include "services/visual_odometry/keyframe_decision.hpp"

#include <algorithm>

namespace fusion_slam {

KeyframeReason decide_keyframe(const KeyframeEvidence& evidence,
                               const VisualOdometryConfig& config) {
  const double moved_m = evidence.T_keyframe_camera.translation().norm();
  const double turned_rad = log_so3(evidence.T_keyframe_camera.linear()).norm();
  if (moved_m < config.still_translation_m && turned_rad < config.still_rotation_rad)
    return KeyframeReason::kNone;
  if (evidence.n_inliers < config.keyframe_inlier_ratio * evidence.n_inliers_at_keyframe)
    return KeyframeReason::kFewInliers;
  if (moved_m > config.keyframe_parallax * std::max(0.5, evidence.median_depth_m))
    return KeyframeReason::kParallax;
  if (turned_rad > config.keyframe_rotation_rad) return KeyframeReason::kRotation;
  return KeyframeReason::kNone;
}

}  // namespace fusion_slam
