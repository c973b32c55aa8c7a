#include "services/pose_graph/graph_solver.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <ceres/problem.h>
#include <ceres/solver.h>

#include "services/pose_graph/graph_costs.hpp"

namespace fusion_slam {
namespace {

constexpr double kMuStep = 4.0;      // graduated non-convexity: mu shrinks by this a round
constexpr int kMaxRounds = 12;       // 4^12: loop errors up to 4000 standard deviations
constexpr int kIterationsRound = 6;  // of a round: its answer is only the next one's start
constexpr int kIterations = 60;

// The problem in Ceres' terms; blocks are one contiguous array in node order.
class Problem {
 public:
  Problem(const PoseGraphConfig& config, const SolveOptions& options, const GraphNodes& nodes,
          const std::vector<GraphEdge>& edges)
      : config_(config), edges_(edges) {
    ceres::Problem::Options ownership;
    ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_ = std::make_unique<ceres::Problem>(ownership);
    select(options, nodes);
    add_edges(options);
    if (options.planar) add_planar_priors();
  }

  bool has_loops() const { return !loops_.empty(); }
  const std::vector<PoseBlock>& blocks() const { return blocks_; }
  void set_blocks(const std::vector<PoseBlock>& blocks) { blocks_ = blocks; }

  double solve(double mu, int max_iterations, SolveReport* report) {
    loss_ = GraduatedLoss(config_.loop_chi2, mu);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.sparse_linear_algebra_library_type =
        ceres::EIGEN_SPARSE;  // no BLAS: same bits everywhere
    options.num_threads = 1;
    options.max_num_iterations = max_iterations;
    options.function_tolerance = 1e-9;
    options.gradient_tolerance = 1e-12;
    options.parameter_tolerance = 1e-10;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
    report->iterations += static_cast<int>(summary.iterations.size());
    if (!summary.IsSolutionUsable()) report->usable = false;
    return summary.final_cost;
  }

  double cost(double mu) {
    loss_ = GraduatedLoss(config_.loop_chi2, mu);
    double cost = 0.0;
    problem_->Evaluate(ceres::Problem::EvaluateOptions(), &cost, nullptr, nullptr, nullptr);
    return cost;
  }

  // Squared error of each loop in units of its covariance, as (edge index, error).
  std::vector<std::pair<std::size_t, double>> loop_errors() const {
    std::vector<std::pair<std::size_t, double>> errors;
    for (const auto& [edge, block] : loops_) {
      double half = 0.0;
      problem_->EvaluateResidualBlock(block, false, &half, nullptr, nullptr);
      errors.emplace_back(edge, 2.0 * half);
    }
    return errors;
  }

  void write_back(GraphNodes* nodes) const {
    for (const auto& [id, index] : index_)
      if (problem_->HasParameterBlock(blocks_[index].data()) &&
          !problem_->IsParameterBlockConstant(blocks_[index].data()))
        nodes->at(id).T_map_base = from_block(blocks_[index].data());
  }

 private:
  // Nodes that may move and those that an edge ties them to.
  void select(const SolveOptions& options, const GraphNodes& nodes) {
    std::set<NodeId> used;
    const auto moves = [&](const NodeId& id) {
      return options.moving.empty() || options.moving.count(id) > 0;
    };
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      if (!moves(edges_[i].from) && !moves(edges_[i].to)) continue;
      used.insert(edges_[i].from);
      used.insert(edges_[i].to);
      selected_edges_.push_back(i);
    }
    for (const NodeId& id : used) {
      index_[id] = blocks_.size();
      blocks_.push_back(to_block(nodes.at(id).T_map_base));
    }
    for (const auto& [id, index] : index_) {
      problem_->AddParameterBlock(blocks_[index].data(), 7, &manifold_);
      if (id == options.anchor || !moves(id))
        problem_->SetParameterBlockConstant(blocks_[index].data());
    }
  }

  void add_edges(const SolveOptions& options) {
    for (const std::size_t i : selected_edges_) {
      const GraphEdge& edge = edges_[i];
      const Matrix6d S = sqrt_information(effective_covariance(config_, edge, options.planar));
      const auto block = problem_->AddResidualBlock(
          new RelativePoseCost(edge.T_from_to, S), edge.kind == EdgeKind::kLoop ? &loss_ : nullptr,
          blocks_[index_.at(edge.from)].data(), blocks_[index_.at(edge.to)].data());
      if (edge.kind == EdgeKind::kLoop) loops_.emplace_back(i, block);
    }
  }

  void add_planar_priors() {
    for (const auto& [id, index] : index_)
      if (!problem_->IsParameterBlockConstant(blocks_[index].data()))
        problem_->AddResidualBlock(new PlanarCost(config_.planar_z_m, config_.planar_tilt_rad),
                                   nullptr, blocks_[index].data());
  }

  const PoseGraphConfig& config_;
  const std::vector<GraphEdge>& edges_;
  PoseManifold manifold_;
  GraduatedLoss loss_{1.0, 1.0};
  std::map<NodeId, std::size_t> index_;
  std::vector<PoseBlock> blocks_;
  std::vector<std::size_t> selected_edges_;
  std::vector<std::pair<std::size_t, ceres::ResidualBlockId>> loops_;
  std::unique_ptr<ceres::Problem> problem_;  // last: gone first
};

double largest_error(const Problem& problem) {
  double largest = 0.0;
  for (const auto& [edge, error] : problem.loop_errors()) largest = std::max(largest, error);
  return largest;
}

// Yang et al. 2020: start with a loss that is convex for the errors there are, then let it become
// what it should be.
double solve_graduated(const PoseGraphConfig& config, Problem* problem, SolveReport* report) {
  double mu = std::max(1.0, 2.0 * largest_error(*problem) / config.loop_chi2);
  for (int round = 0; round < kMaxRounds && mu > 1.0; ++round) {
    problem->solve(mu, kIterationsRound, report);
    mu = std::max(1.0, mu / kMuStep);
  }
  return problem->solve(1.0, kIterations, report);
}

}  // namespace

Matrix6d effective_covariance(const PoseGraphConfig& config, const GraphEdge& edge, bool planar) {
  Matrix6d covariance = edge.covariance;
  if (edge.kind != EdgeKind::kLoop) covariance *= config.tracker_optimism;
  if (edge.kind == EdgeKind::kLidar || edge.kind == EdgeKind::kTie ||
      edge.kind == EdgeKind::kOdometry) {
    const double z = planar ? config.lidar_planar_z_m : config.lidar_free_z_m;
    const double tilt = planar ? config.lidar_planar_tilt_rad : config.lidar_free_tilt_rad;
    for (const int unseen : {2, 3, 4}) {
      covariance.row(unseen).setZero();
      covariance.col(unseen).setZero();
      covariance(unseen, unseen) = unseen == 2 ? z * z : tilt * tilt;
    }
  }
  const double t = config.floor_translation_m;
  const double r = config.floor_rotation_rad;
  covariance.diagonal().head<3>().array() += t * t;
  covariance.diagonal().tail<3>().array() += r * r;
  return covariance;
}

SolveReport solve_graph(const PoseGraphConfig& config, const SolveOptions& options,
                        GraphNodes* nodes, std::vector<GraphEdge>* edges) {
  SolveReport report;
  Problem problem(config, options, *nodes, *edges);
  if (problem.blocks().empty()) return report;

  const std::vector<PoseBlock> start = problem.blocks();
  report.initial_cost = problem.cost(1.0);
  report.final_cost = problem.solve(1.0, kIterations, &report);
  if (problem.has_loops()) {
    const std::vector<PoseBlock> from_here = problem.blocks();
    problem.set_blocks(start);
    const double graduated_cost = solve_graduated(config, &problem, &report);
    if (graduated_cost < report.final_cost)
      report.final_cost = graduated_cost;
    else
      problem.set_blocks(from_here);
  }
  if (!report.usable || report.final_cost > report.initial_cost) return report;

  problem.write_back(nodes);
  for (const auto& [edge, error] : problem.loop_errors()) {
    double rho[3];
    GraduatedLoss(config.loop_chi2, 1.0).Evaluate(error, rho);
    (*edges)[edge].loop_weight = rho[1];
    if (rho[1] < 0.1) ++report.loops_outvoted;
  }
  return report;
}

}  // namespace fusion_slam
