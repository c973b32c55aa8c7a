// Tracks the local map: matches and robust pose, a wide search first and then a narrow one.
#pragma once

#include <optional>

#include "libs/camera/camera_model.hpp"
#include "libs/features/pose_refiner.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/local_map.hpp"
#include "services/visual_odometry/projection_matcher.hpp"

namespace fusion_slam {

struct PoseEstimate {
  SE3 T_odom_camera = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // given the local map, camera axes
  ProjectionMatches matched;                   // inliers only
};

// A wide search around the guess, then a narrow one around what it gave (Mur-Artal et al. 2015,
// sections V-C and V-D); nothing when fewer than config.min_inliers agree. Pure.
std::optional<PoseEstimate> track_local_map(const LocalMap& map, const CameraModel& camera,
                                            const SE3& guess_T_odom_camera, const FeatureSet& set,
                                            const std::vector<double>& scale_of_octave,
                                            double radius_px, const VisualOdometryConfig& config);

// The narrow search alone, around a pose that is known otherwise (`prior`): any number of features,
// also none, makes it better. Pure.
PoseEstimate track_from_prior(const LocalMap& map, const CameraModel& camera,
                              const CameraPosePrior& prior, const FeatureSet& set,
                              const std::vector<double>& scale_of_octave,
                              const VisualOdometryConfig& config);

}  // namespace fusion_slam
