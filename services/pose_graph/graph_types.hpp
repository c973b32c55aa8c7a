// Nodes of the pose graph. T_map_base: pose of the robot's base when the node's measurement was
// taken.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "libs/graph/edge.hpp"

namespace fusion_slam {

struct GraphNode {
  std::int64_t utime_us = 0;
  SE3 T_map_base = SE3::Identity();
  SE3 T_odom_base = SE3::Identity();  // as the tracker believed
};

using GraphNodes = std::map<NodeId, GraphNode>;

}  // namespace fusion_slam
