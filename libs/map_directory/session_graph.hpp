// All nodes of a session's graph as GRAPH last said them, to be said again in one piece.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "fusion_slam/graph_t.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"

namespace fusion_slam {

class SessionGraph {
 public:
  // In any order, however many; poses that are none are left out.
  void add(const graph_t& message);

  bool empty() const { return nodes_.empty(); }
  std::int64_t n_loops() const { return n_loops_; }
  const std::map<NodeId, std::pair<std::int64_t, graph_node_t>>& nodes() const { return nodes_; }
  std::map<NodeId, SE3> T_map_nodes() const;

  // The whole graph: parts below 60 KB, `complete`.
  std::vector<graph_t> messages() const;

 private:
  std::int64_t revision_ = 0;
  std::int64_t utime_us_ = 0;
  std::int32_t n_loops_ = 0;
  std::vector<loop_state_t> switched_off_;
  std::map<NodeId, std::pair<std::int64_t, graph_node_t>> nodes_;  // with the revision that said it
};

}  // namespace fusion_slam
