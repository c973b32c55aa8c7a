// Nodes and edges of the pose graph. T_map_base: pose of the robot's base when the node's
// measurement was taken.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"

namespace fusion_slam {

enum class EdgeKind {
  kVisual,    // 6-DoF, keyframe to keyframe (or to a LiDAR node in the camera's trajectory)
  kLidar,     // x, y, yaw, LiDAR node to LiDAR node
  kTie,       // x, y, yaw of a keyframe in the LiDAR's trajectory at the same time
  kOdometry,  // wheels, where a track had to start anew
  kRestart,   // a track started anew and nothing better is known
  kLoop,      // CONSTRAINT: may be wrong, hence a robust loss
};

struct GraphNode {
  std::int64_t utime_us = 0;
  SE3 T_map_base = SE3::Identity();
  SE3 T_odom_base = SE3::Identity();  // as the tracker believed
};

struct GraphEdge {
  EdgeKind kind = EdgeKind::kVisual;
  NodeId from;
  NodeId to;
  SE3 T_from_to = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of xi in T_from_to * Exp(xi)
  double loop_weight = 1.0;  // after the last solve; below 0.1: outvoted. 1 for all but loops
};

using GraphNodes = std::map<NodeId, GraphNode>;

}  // namespace fusion_slam
