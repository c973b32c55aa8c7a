// What the loop detector may be told.
#pragma once

#include <cstdint>

#include "libs/features/matching.hpp"
#include "libs/features/pose_refiner.hpp"
#include "libs/features/rigid_ransac.hpp"

namespace fusion_slam {

struct LoopDetectorConfig {
  // Stage 1, appearance.
  int not_before_keyframes = 15;  // the newest keyframes are the odometry's own business
  std::int64_t not_before_us = 5'000'000;
  int max_candidates = 3;   // of one keyframe, best first
  double min_votes = 0.04;  // share of the keyframe's features that vote for the place
  int max_distance =
      48;  // bits: a vote; stricter than matching, for each feature meets the whole map
  int index_tables = 8;
  int index_key_bits = 16;

  // Stage 2, geometry.
  int min_inliers = 25;           // of RANSAC and refinement; chance gives 3 to 8
  double pixel_sigma = 0.8;       // px at octave 0: corners of two views from apart
  double scale_factor = 1.2;      // of the pyramid the features come from
  double guided_radius_px = 8.0;  // second search, with the pose known
  MatchConfig matching;
  RansacConfig ransac;
  RefineConfig refine;

  // Stages 3 (LiDAR) and 4 (consistency) don't run yet, so nothing is accepted. True: accept on the
  // first two alone.
  bool accept_without_lidar = false;
};

}  // namespace fusion_slam
