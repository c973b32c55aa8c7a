// What it takes to know a place again: by the looks of it, and by its geometry. One set for every
// robot and building.
#pragma once

#include <cstdint>

#include "libs/features/matching.hpp"
#include "libs/features/pose_refiner.hpp"
#include "libs/features/rigid_ransac.hpp"

namespace fusion_slam {

struct AppearanceConfig {
  int not_before_keyframes = 15;  // the newest keyframes are the odometry's own business
  std::int64_t not_before_us = 5'000'000;
  int max_candidates = 3;   // of one keyframe, best first
  double min_votes = 0.04;  // share of the keyframe's asked features that vote for the place
  int max_distance =
      48;  // bits: a vote; stricter than matching, for each feature meets the whole map
  int index_tables = 8;
  int index_key_bits = 16;
  // Of a keyframe, evenly over its octaves: more cost time and find the same places.
  int asked_features = 150;
  int indexed_features = 500;
};

struct GeometryConfig {
  int min_inliers = 25;           // of RANSAC and refinement; chance gives 3 to 8
  double pixel_sigma = 0.8;       // px at octave 0: corners of two views from apart
  double scale_factor = 1.2;      // of the pyramid the features come from
  double guided_radius_px = 8.0;  // second search, with the pose known; the third has half of it
  double guided_octaves = 2.0;    // beside the one that the distances say
  double optimism = 4.0;          // on the refined pose's covariance: features err together
  // A few features far away agree on one motion and hardly fix it. Such a view shows which place
  // it is, not where the camera is there: a scan must tell, or it is no closure. A sixth and a
  // fifth of what would be a wrong closure (0.3 m, 0.1 rad): simulated ones err by up to 3.7 of
  // these sigmas.
  double most_sigma_m = 0.05;
  double most_sigma_rad = 0.02;
  MatchConfig matching;
  RansacConfig ransac;
  RefineConfig refine;
};

}  // namespace fusion_slam
