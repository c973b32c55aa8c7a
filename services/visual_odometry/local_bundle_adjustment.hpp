// Windowed bundle adjustment: the poses of a few keyframes and the landmarks they see, at once.
// Sources: Triggs et al. 2000; Mur-Artal et al. 2015, section VI-E (what moves and what holds);
// Huber 1964; depth noise as in Khoshelham & Elberink 2012.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

struct BundleResult {
  int n_poses = 0;      // that moved
  int n_landmarks = 0;  // that moved
  int n_observations = 0;
  int n_outliers = 0;  // observations that were unlinked afterwards
  double initial_cost = 0.0;
  double final_cost = 0.0;
};

// Moves the keyframes in `moving` (ascending; of those without any fixed neighbour the oldest
// holds the rest) and the landmarks they see so that reprojections and depths fit best, by
// Levenberg-Marquardt on the Schur complement (Ceres, one thread, deterministic). Keyframes of the
// map that are not in `moving` hold still. A landmark with one observation moves rigidly with its
// keyframe. Observations that don't fit afterwards are unlinked.
BundleResult adjust_bundle(const CameraModel& camera, const std::vector<std::int64_t>& moving,
                           const std::vector<double>& scale_of_octave,
                           const VisualOdometryConfig& config, VisualMap* map);

}  // namespace fusion_slam
