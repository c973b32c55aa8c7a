// What visual odometry may be told. Everything else is derived from the camera's model.
#pragma once

#include <cstdint>

#include "libs/features/matching.hpp"
#include "libs/features/orb_extractor.hpp"
#include "libs/features/pose_refiner.hpp"
#include "libs/features/rigid_ransac.hpp"

namespace fusion_slam {

struct VisualOdometryConfig {
  OrbConfig orb;

  // Guided matching. The wide radius is what a hand-held camera's change of speed moves a pixel in
  // 1/30 s; the narrow one is used once the pose is known.
  double wide_radius_px = 20.0;
  double narrow_radius_px = 5.0;
  int max_distance = 64;  // bits; 128 +- 8 (many bits: +- 20) is chance
  double ratio = 0.85;    // between candidates inside one radius
  double octave_tolerance = 1.5;

  // Noise. A corner is found to about half a pixel of its own octave.
  double pixel_sigma = 0.6;
  RefineConfig refine;
  RansacConfig ransac;
  MatchConfig relocalisation;

  // States.
  int min_inliers_ok = 40;                  // fewer: WEAK
  int min_inliers = 15;                     // fewer: LOST
  int min_start_features = 60;              // with depth, to start a map from one frame
  std::int64_t lost_patience_us = 500'000;  // then a new segment is started

  // Keyframes, by information; none while standing still.
  double still_translation_m = 0.015;
  double still_rotation_rad = 0.015;
  double keyframe_rotation_rad = 0.20;
  double keyframe_parallax = 0.08;      // translation / median depth
  double keyframe_inlier_ratio = 0.60;  // of those right after the last keyframe

  // Local map: keyframes whose points are tracked. More of them: less drift when the camera looks
  // at a place again.
  int local_map_keyframes = 15;
};

}  // namespace fusion_slam
