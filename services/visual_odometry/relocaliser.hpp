// Finds the pose in the local map without a guess: descriptors, then RANSAC, then refinement.
#pragma once

#include <optional>

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/local_map.hpp"

namespace fusion_slam {

// T_odom_camera of the frame whose features these are; nothing when no pose explains enough
// matches. Deterministic.
std::optional<SE3> relocalise(const LocalMap& map, const CameraModel& camera, const FeatureSet& set,
                              const std::vector<double>& scale_of_octave,
                              const VisualOdometryConfig& config);

}  // namespace fusion_slam
