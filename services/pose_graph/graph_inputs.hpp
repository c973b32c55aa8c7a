// What goes into the pose graph and comes out of it, in plain types.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"
#include "services/pose_graph/landmark_store.hpp"

namespace fusion_slam {

enum class PoseState : std::int8_t { kUnknown = 0, kOk = 1, kWeak = 2, kLost = 3 };

struct NodeInput {  // KEYFRAME or LIDAR_NODE
  NodeId id;
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  std::int64_t previous_id = 0;  // of the same kind; 0: none, the track starts (anew) here
  SE3 T_previous_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of T_previous_base
  // Earlier keyframes whose motion since their previous one is known better now.
  struct Refined {
    std::int64_t id = 0;
    SE3 T_previous_base = SE3::Identity();
  };
  std::vector<Refined> refined;
  std::vector<SeenFeature> seen;  // of keyframes: features that show a known point
};

struct PoseInput {  // VISUAL_POSE (sensor kKeyframe) or LIDAR_POSE (kLidar)
  NodeKind sensor = NodeKind::kKeyframe;
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();
  PoseState state = PoseState::kUnknown;
  std::string reason;
  std::optional<NodeId> reference;
  SE3 T_reference_base = SE3::Identity();
  std::int64_t fix_utime_us = 0;
  int n_matched = 0;
};

struct PoseOutput {  // POSE
  std::int64_t utime_us = 0;
  SE3 T_map_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();
  PoseState state = PoseState::kUnknown;
  std::string reason;
  NodeId reference;
  SE3 T_reference_base = SE3::Identity();
  std::int64_t fix_utime_us = 0;
  int n_matched = 0;
};

struct LoopInput {  // CONSTRAINT
  NodeId from;
  NodeId to;
  SE3 T_from_to = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();
  std::vector<std::pair<int, int>> same_features;  // indices into the views of the two keyframes
};

struct LoopState {  // a loop that was switched off
  NodeId from;
  NodeId to;
  double squared_error = 0.0;  // in units of its covariance
  std::string reason;
};

}  // namespace fusion_slam
