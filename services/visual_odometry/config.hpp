// What visual odometry may be told. Everything else is derived from the camera's model.
#pragma once

#include <cstdint>

#include "libs/features/matching.hpp"
#include "libs/features/orb_extractor.hpp"
#include "libs/features/pose_refiner.hpp"
#include "libs/features/rigid_ransac.hpp"
#include "services/visual_odometry/surface_tracking.hpp"

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

  // Before a bare wall surfaces and the speed carry the pose on. An image full of features that
  // nobody knows is another place, however alike its surfaces. The speed is what is left along a
  // wall: after this time it says nothing any more.
  SurfaceConfig surfaces;
  double carry_features = 0.5;  // of orb.n_features: more of them is no bare wall
  std::int64_t carry_us = 2'000'000;

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

  // Local map: keyframes whose landmarks are tracked. More of them: less drift when the camera
  // looks at a place again.
  int local_recent_keyframes = 10;
  int local_covisible_keyframes = 10;
  int local_near_keyframes = 10;
  double local_near_m = 2.0;
  double local_near_cosine = 0.5;  // 60 degrees between the views
  int agree_landmarks = 15;        // of a near keyframe, found in the newest one
  double agree_share = 0.5;        // of these where they should be: else the place isn't used
  int covisible_landmarks = 15;    // shared, to be neighbours at all

  // Local mapping. The adjustment takes about 100 ms; 6 frames are 200 ms.
  // true: its result is taken up after mapping_frames or at the next keyframe, and tracking waits
  // for it then: the frames alone decide, replays give the same bytes. false, on a robot: when it
  // is there; tracking never waits.
  bool wait_for_mapping = true;
  int mapping_frames = 6;
  int bundle_keyframes = 8;         // that move
  int bundle_fixed_keyframes = 12;  // that hold them
  int bundle_iterations = 6;
  double bundle_outlier_2d = 13.8;  // chi square, 99.9 %
  double bundle_outlier_3d = 16.3;
  double bundle_tie_gate = 16.8;  // of what surfaces say between keyframes: 6 freedoms, 99 %
  double fuse_radius_px = 3.0;
  int fuse_distance = 50;          // bits
  double min_parallax_rad = 0.02;  // of bearing-only features, to give them a place
  int trial_frames = 15;           // a landmark is judged after it should have been seen so often
  double min_found_ratio = 0.25;
  int trial_keyframes = 3;       // and after so many keyframes must have been seen by a second one
  int trial_found = 4;           // or in so many frames
  int redundant_views = 3;       // of a landmark, by other keyframes
  double redundant_share = 0.9;  // of a keyframe's landmarks

  // Long drives in the same rooms: of old keyframes that show the same, the oldest and the newest
  // are enough. Younger ones are left alone: a place is seen a few times before it is known.
  std::int64_t thin_age_us = 120'000'000;
  double thin_m = 1.0;        // half of local_near_m: what is left still reaches
  double thin_cosine = 0.87;  // 30 degrees
  int thin_older = 2;
  int thin_newer = 2;

  // Each switch off: an ablation. The LiDAR's part:
  bool use_surfaces = true;
  bool use_planar = true;  // the floor, when ROBOT_MODEL says planar
  bool use_lidar_depth = true;
  bool use_lidar_motion = true;
  std::int64_t scan_age_us = 150'000;  // older scans say nothing about this frame
  double lidar_min_incidence = 0.26;   // sine: surfaces seen at less than 15 degrees are left out
  double lidar_reach_m = 0.03;         // from the LiDAR's plane: features without depth
  double lidar_reach_agreed_m = 0.30;  // features whose own depth agrees

  // What the pose graph must move a keyframe by, against the newest one, to be followed: less is
  // its own noise, local mapping knows better.
  double revision_m = 0.03;
  double revision_rad = 0.01;
  int reloc_inliers = 25;            // to be found again
  int join_inliers = 30;             // to join two segments
  std::size_t reloc_candidates = 3;  // places tried in one frame
  // Vision that is WEAK, or whose agreeing features are less than this share of those seen, and
  // that moves this much otherwise than the LiDAR says is LOST.
  double doubted_share = 0.2;
  double disagree_m = 0.15;
  double disagree_rad = 0.15;
  int settle_keyframes = 10;  // after so many newer ones a keyframe's edge no longer changes
};

}  // namespace fusion_slam
