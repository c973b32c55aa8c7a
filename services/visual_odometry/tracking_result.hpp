// What visual odometry says about a frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libs/features/feature.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

enum class TrackingState { kUnknown, kOk, kWeak, kLost };

// The edge from an earlier keyframe to its previous one as local mapping has left it, for good.
struct RefinedEdge {
  std::int64_t id = 0;
  SE3 T_previous_base = SE3::Identity();
};

struct Keyframe {
  std::int64_t id = 0;  // 1, 2, 3 ...
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  std::int64_t previous_id = 0;  // 0: none, a new segment
  SE3 T_previous_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();     // of T_previous_base, base axes
  FeatureSet features;                            // ideal pixels
  std::vector<std::int64_t> landmark_of_feature;  // one a feature; 0: none
  std::vector<RefinedEdge> refined;               // each keyframe at most once in a session
};

struct TrackingResult {
  std::int64_t utime_us = 0;
  TrackingState state = TrackingState::kUnknown;
  std::string reason;  // why the state is not OK
  SE3 T_odom_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of T_odom_base given the local map, base axes
  std::int64_t reference_id = 0;               // keyframe; 0: none yet
  SE3 T_reference_base = SE3::Identity();
  std::int64_t fix_utime_us = 0;  // when the pose was last measured
  int n_matched = 0;
  std::optional<Keyframe> keyframe;  // when this frame became one
};

// Since the start, for people.
struct VisualOdometryCounts {
  int mappings = 0;
  int mapping_waits = 0;  // of these: not done when their result was due, so that tracking waited
  int mappings_late = 0;  // keyframes that found the thread at work, and wait for the next job
  int triangulated = 0;
  int fused = 0;
  int observations_refused = 0;  // by bundle adjustment
  int landmarks_culled = 0;
  int keyframes_culled = 0;
  int keyframes_thinned = 0;  // old ones of places that were seen before and after
  int relocalisations = 0;
  int joins = 0;
  int carried_frames = 0;     // by surfaces and the speed
  int revised_keyframes = 0;  // moved because the graph was
  std::int64_t lidar_depths = 0;
  std::int64_t lidar_guesses = 0;  // frames that were tracked from the LiDAR's prediction
};

}  // namespace fusion_slam
