// Stage 2: is there one rigid motion that puts the features of two keyframes on top of each other?
#pragma once

#include <utility>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/places/config.hpp"

namespace fusion_slam {

struct GeometryCheck {
  int n_matches = 0;  // by descriptor alone
  int n_inliers = 0;
  SE3 T_older_newer = SE3::Identity();         // camera to camera
  Matrix6d covariance = Matrix6d::Identity();  // of it, in the newer camera's axes
  // The worst directions', with the factor of GeometryConfig::optimism (the covariance is without).
  double sigma_m = 1.0;
  double sigma_rad = 1.0;
  std::vector<std::pair<int, int>> same;  // inliers: (feature of the older, of the newer)
};

// Does it say where the camera is, and not only which place it sees?
inline bool is_precise(const GeometryCheck& check, const GeometryConfig& config) {
  return check.sigma_m <= config.most_sigma_m && check.sigma_rad <= config.most_sigma_rad;
}

// Matches by descriptor, RANSAC, search again around the pose found, refinement. n_inliers 0: no
// pose. Deterministic.
GeometryCheck check_geometry(const CameraModel& camera, const FeatureSet& older,
                             const FeatureSet& newer, const GeometryConfig& config);

}  // namespace fusion_slam
