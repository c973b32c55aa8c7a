// Guided matching: each point of the local map is looked for where the predicted pose says it is.
#pragma once

#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature_grid.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/local_map.hpp"

namespace fusion_slam {

struct MapMatch {
  int point = 0;  // index into the local map
  int feature = 0;
  int distance = 0;
};

struct ProjectionMatches {
  std::vector<MapMatch> matches;  // each point and each feature at most once; ascending in feature
  std::vector<int> in_view;       // points that should be seen from the guessed pose
};

// Points in front of the camera, inside the image, seen from within 60 degrees of where they were
// last seen, matched to the most similar feature within radius_px * scale, of a fitting octave and
// depth.
ProjectionMatches match_by_projection(const LocalMap& map, const CameraModel& camera,
                                      const SE3& guess_T_odom_camera, const FeatureSet& set,
                                      const FeatureGrid& grid,
                                      const std::vector<double>& scale_of_octave, double radius_px,
                                      const VisualOdometryConfig& config);

// Whether a feature's depth can't be that of a point at z_m, however good the guess.
bool other_depth(const Feature& feature, const CameraModel& camera, double z_m);

}  // namespace fusion_slam
