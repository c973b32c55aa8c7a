// Finds the pose in the map without a guess: places that look alike, then RANSAC on the landmarks
// of each, then tracking around what it gives.
#pragma once

#include <optional>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/pose_tracking.hpp"

namespace fusion_slam {

struct Relocalised {
  std::int64_t keyframe = 0;  // whose place it is
  LocalMap local;             // that the estimate was made against
  PoseEstimate estimate;
};

// Tries the candidate keyframes in order; the first whose place explains at least min_inliers
// features. Deterministic.
std::optional<Relocalised> relocalise(const VisualMap& map,
                                      const std::vector<std::int64_t>& candidates,
                                      const CameraModel& camera, const FeatureSet& set,
                                      const std::vector<double>& scale_of_octave, int min_inliers,
                                      const VisualOdometryConfig& config);

}  // namespace fusion_slam
