// Least squares over a pose graph: where are the nodes so that all edges agree best? Robust against
// wrong loops.
#pragma once

#include <set>
#include <vector>

#include "services/pose_graph/config.hpp"
#include "services/pose_graph/graph_types.hpp"

namespace fusion_slam {

struct SolveOptions {
  bool planar = false;      // the robot's base stays on z = 0
  NodeId anchor;            // never moves; must be a node
  std::set<NodeId> moving;  // only these may move; empty: all
};

struct SolveReport {
  bool usable = true;  // false: the solver failed and nothing was changed
  double initial_cost = 0.0;
  double final_cost = 0.0;
  int iterations = 0;
  int loops_outvoted = 0;
};

// Moves nodes' T_map_base and sets loops' loop_weight. Each edge's ends must be nodes.
// Deterministic: one thread, nodes in id order, edges in their own. With loops it solves twice,
// once from where the nodes are and once by graduated non-convexity (trust every loop first, then
// doubt the ones that don't fit), and keeps the cheaper answer.
SolveReport solve_graph(const PoseGraphConfig& config, const SolveOptions& options,
                        GraphNodes* nodes, std::vector<GraphEdge>* edges);

// The covariance an edge is solved with: its own, a tracker's bias allowed for, what its sensor
// can't see widened or pinned, and the floor added.
Matrix6d effective_covariance(const PoseGraphConfig& config, const GraphEdge& edge, bool planar);

}  // namespace fusion_slam
