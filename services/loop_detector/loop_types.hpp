// What goes through the loop detector, in plain types.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "libs/features/feature.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"
#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

struct LoopKeyframe {
  std::int64_t id = 0;
  std::int64_t seq = 0;  // of its message; 0: unknown
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  std::int64_t previous_id = 0;  // 0: none
  SE3 T_previous_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity() * 1e-4;  // of T_previous_base
  FeatureSet features;                                // ideal pixels
};

struct LoopScan {
  struct Membership {
    std::int64_t submap_id = 0;
    SE3 T_submap_base = SE3::Identity();
  };
  std::int64_t id = 0;
  std::int64_t seq = 0;  // of its message; 0: unknown
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  std::int64_t previous_id = 0;
  SE3 T_previous_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity() * 1e-4;
  std::vector<Membership> submaps;
  Points points_base;
};

struct StageVerdict {
  std::string stage;  // appearance, geometry, lidar, consistency
  double score = 0.0;
  double threshold = 0.0;
  bool passed = false;
  std::string reason;
};

enum class LoopSource { kVision, kLidar, kBoth };

// What a candidate measured: becomes a CONSTRAINT when the candidate is accepted.
struct LoopMeasurement {
  NodeId from;  // older
  NodeId to;
  SE3 T_from_to = SE3::Identity();             // base to base
  Matrix6d covariance = Matrix6d::Identity();  // of it, in the axes of `to`
  // Features that are one point of the world: indices into the two keyframes. Empty for LiDAR.
  std::vector<std::pair<int, int>> same_features;
  const char* by = "";  // "visual loop", "lidar loop"
};

struct LoopCandidate {
  NodeId from;  // the older node
  NodeId to;    // the newer
  std::int64_t utime_us = 0;
  LoopSource source = LoopSource::kVision;
  bool accepted = false;
  std::vector<StageVerdict> stages;           // all four, in order
  std::vector<LoopMeasurement> measurements;  // none when a stage failed before the last
};

}  // namespace fusion_slam
