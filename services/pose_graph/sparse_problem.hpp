// The normal equations of a pose graph in 6x6 blocks: linearised, damped, solved.
#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/SparseCore>

#include "services/pose_graph/config.hpp"
#include "services/pose_graph/eliminated_part.hpp"
#include "services/pose_graph/graph_solver.hpp"
#include "services/pose_graph/graph_types.hpp"
#include "services/pose_graph/normal_equations.hpp"

namespace fusion_slam {

// A pose graph's cost as a function of the poses that may move. Not thread-safe.
class SparseProblem {
 public:
  // Takes those of the edges that have a moving end. Variables in the order of their ids.
  SparseProblem(const PoseGraphConfig& config, const SolveOptions& options, const GraphNodes& nodes,
                const std::vector<GraphEdge>& edges);

  // Of a node; -1: it stands still.
  int variable_of(const NodeId& id) const;
  int n_variables() const { return static_cast<int>(variables_.size()); }
  // For the tests: most work a factorisation may be (normal_equations.hpp).
  void set_most_work(double multiplications) { equations_.most_work = multiplications; }
  // Before the first minimise(); must outlive it. Its cost is part of the whole.
  void attach(EliminatedPart* part) { part_ = part; }

  bool empty() const { return variables_.empty(); }
  bool has_loops() const { return has_loops_; }
  Poses start() const { return start_; }
  // Half the sum of squared errors; loops by Geman-McClure with scale mu * loop_chi2.
  double cost(const Poses& poses, double mu) const;
  std::vector<std::pair<std::size_t, double>> loop_errors(const Poses& poses) const;

  // Levenberg-Marquardt from `poses`; returns the final cost. False in `usable` when the equations
  // can't be solved.
  double minimise(double mu, int max_iterations, Poses* poses, int* iterations, bool* usable);

  void write_back(const Poses& poses, GraphNodes* nodes) const;

 private:
  struct Term {
    int from = -1;  // variable; -1: fixed
    int to = -1;
    SE3 T_from;  // of fixed ends
    SE3 T_to;
    SE3 measured;
    Matrix6d sqrt_information;
    std::size_t edge = 0;
    bool loop = false;
    int block_from = -1, block_to = -1, block_cross = -1;  // in the matrix
    bool cross_transposed = false;
  };
  Vector6d error(const Term& term, const Poses& poses, Matrix6d* J_from, Matrix6d* J_to) const;
  void make_pattern();
  void linearise(const Poses& poses, double mu);
  void add_part(const Poses& poses);
  void fill(double damping);

  const PoseGraphConfig& config_;
  bool planar_;
  double enough_;
  std::shared_ptr<const std::atomic<bool>> unwanted_;
  bool has_loops_ = false;
  std::vector<NodeId> variables_;
  Poses start_;
  std::vector<Term> terms_;
  EliminatedPart* part_ = nullptr;
  std::vector<int> part_block_;        // by pair of the part
  std::vector<char> part_transposed_;  // the block's rows are the smaller variable's
  bool has_pattern_ = false;

  // Lower block triangle in elimination order.
  std::vector<int> order_;                      // variable -> place in the matrix
  std::vector<std::pair<int, int>> positions_;  // of each block: (row, column) place
  std::vector<Matrix6d> blocks_;
  std::vector<int> diagonal_;                // variable -> block
  std::vector<std::vector<int>> by_column_;  // blocks of a column place, by row
  Eigen::VectorXd gradient_;                 // by place
  NormalEquations equations_;
};

}  // namespace fusion_slam
