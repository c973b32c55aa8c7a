// Guided matching: each map point is looked for where the predicted pose says it is.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature_grid.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/local_map.hpp"

namespace fusion_slam {

struct MapMatch {
  std::int64_t point = 0;
  int feature = 0;
  int distance = 0;
};

struct ProjectionMatches {
  std::vector<MapMatch> matches;  // each point and each feature at most once; ascending in feature
  std::vector<std::int64_t> in_view;  // points that should be seen from the guessed pose
};

// Points in front of the camera, inside the image, seen from within 60 degrees of where they were
// last seen, matched to the most similar feature within radius_px * scale, of a fitting octave and
// depth.
ProjectionMatches match_by_projection(const LocalMap& map, const CameraModel& camera,
                                      const SE3& guess_T_odom_camera, const FeatureSet& set,
                                      const FeatureGrid& grid,
                                      const std::vector<double>& scale_of_octave, double radius_px,
                                      const VisualOdometryConfig& config);

}  // namespace fusion_slam
