// Edges of the pose graph: what was measured between two nodes, and by what.
#pragma once

#include <optional>

#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"

namespace fusion_slam {

enum class EdgeKind {
  kVisual,    // 6-DoF, keyframe to keyframe (or to a LiDAR node in the camera's trajectory)
  kLidar,     // x, y, yaw: a scan in its submap (submap's anchor to node), or node to node
  kTie,       // x, y, yaw of a keyframe in the LiDAR's trajectory at the same time
  kOdometry,  // wheels, where a track had to start anew
  kRestart,   // a track started anew and nothing better is known
  kLoop,      // CONSTRAINT: may be wrong, hence a robust loss
};

struct GraphEdge {
  EdgeKind kind = EdgeKind::kVisual;
  NodeId from;
  NodeId to;
  SE3 T_from_to = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of xi in T_from_to * Exp(xi), as the sensor said
  double loop_weight = 1.0;  // after the last solve; below 0.1: outvoted. 1 for all but loops
  // What global bundle adjustment says instead of T_from_to; its own measurement stays T_from_to.
  std::optional<SE3> adjusted = std::nullopt;
  // As measured, before an end left the graph and its carrier took its place; id 0: from and to.
  NodeId said_from = {};
  NodeId said_to = {};
};

}  // namespace fusion_slam
