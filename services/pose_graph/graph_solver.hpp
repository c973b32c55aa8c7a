// Least squares over a pose graph: where are the nodes so that all edges agree best? Robust against
// wrong loops.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "services/pose_graph/config.hpp"
#include "services/pose_graph/graph_types.hpp"

namespace fusion_slam {

struct SolveOptions {
  bool planar = false;      // the robot's base stays on z = 0
  NodeId anchor;            // never moves; must be a node
  std::set<NodeId> moving;  // only these may move; empty: all
  // Doubt loops anew: when some don't fit from where the nodes are, solve once more by graduated
  // non-convexity and keep the cheaper answer. Takes several times as long.
  bool doubt = true;
  int max_iterations = 60;
  double enough = 1e-7;  // done when a step lowers the cost by less than this share of it
  // Set by another thread when nobody wants the answer any more: the step it is at is the last, and
  // the report not usable.
  std::shared_ptr<const std::atomic<bool>> unwanted = nullptr;
};

struct SolveReport {
  bool usable = true;  // false: the solver failed and nothing was changed
  double initial_cost = 0.0;
  double final_cost = 0.0;
  int iterations = 0;
  int loops_outvoted = 0;
  // (edge index, squared error in units of its covariance) of each loop, after the solve.
  std::vector<std::pair<std::size_t, double>> loop_errors;
};

// Moves nodes' T_map_base and sets loops' loop_weight. Each edge's ends must be nodes.
// Levenberg-Marquardt on T * (t, Exp(r)), sparse Cholesky in an order that keeps chains thin (AMD);
// loops by iteratively reweighted least squares with a Geman-McClure loss. Deterministic: one
// thread, nodes in id order, edges in their own.
SolveReport solve_graph(const PoseGraphConfig& config, const SolveOptions& options,
                        GraphNodes* nodes, std::vector<GraphEdge>* edges);

// Squared error of an edge where the nodes are now, in units of its effective covariance.
double edge_error(const PoseGraphConfig& config, bool planar, const GraphNodes& nodes,
                  const GraphEdge& edge);

}  // namespace fusion_slam
