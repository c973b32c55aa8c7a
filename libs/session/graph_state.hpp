// Where the nodes are, from GRAPH messages in whatever order and however many.
#pragma once

#include <cstdint>
#include <map>

#include "fusion_slam/graph_t.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"

namespace fusion_slam {

class GraphState {
 public:
  void add(const graph_t& message);
  std::int64_t revision() const { return revision_; }
  std::map<NodeId, SE3> T_map_nodes() const;

 private:
  struct Node {
    std::int64_t revision = 0;
    SE3 T_map_base = SE3::Identity();
  };
  std::int64_t revision_ = 0;
  std::map<NodeId, Node> nodes_;
};

}  // namespace fusion_slam
