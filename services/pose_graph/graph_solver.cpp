#include "services/pose_graph/graph_solver.hpp"

#include <algorithm>

#include "services/pose_graph/graph_costs.hpp"
#include "services/pose_graph/sparse_problem.hpp"

namespace fusion_slam {
namespace {

constexpr double kMuStep = 4.0;      // graduated non-convexity: mu shrinks by this a round
constexpr int kMaxRounds = 12;       // 4^12: loop errors up to 4000 standard deviations
constexpr int kIterationsRound = 3;  // of a round: its answer is only the next one's start
constexpr double kDoubted = 0.25;    // a loop of less weight than this hardly counts

double weight_of(const PoseGraphConfig& config, double squared_error) {
  double rho[3];
  GraduatedLoss(config.loop_chi2, 1.0).Evaluate(squared_error, rho);
  return rho[1];
}

double largest_error(const SparseProblem& problem, const Poses& poses) {
  double largest = 0.0;
  for (const auto& [edge, error] : problem.loop_errors(poses)) largest = std::max(largest, error);
  return largest;
}

// Yang et al. 2020: start with a loss that is convex for the errors there are, then let it become
// what it should be.
double solve_graduated(const PoseGraphConfig& config, int max_iterations, SparseProblem* problem,
                       Poses* poses, SolveReport* report) {
  double mu = std::max(1.0, 2.0 * largest_error(*problem, *poses) / config.loop_chi2);
  for (int round = 0; round < kMaxRounds && mu > 1.0; ++round) {
    problem->minimise(mu, kIterationsRound, poses, &report->iterations, &report->usable);
    mu = std::max(1.0, mu / kMuStep);
  }
  return problem->minimise(1.0, max_iterations, poses, &report->iterations, &report->usable);
}

}  // namespace

SolveReport solve_graph(const PoseGraphConfig& config, const SolveOptions& options,
                        GraphNodes* nodes, std::vector<GraphEdge>* edges) {
  SolveReport report;
  SparseProblem problem(config, options, *nodes, *edges);
  if (problem.empty()) return report;

  Poses poses = problem.start();
  report.initial_cost = problem.cost(poses, 1.0);
  report.final_cost =
      problem.minimise(1.0, options.max_iterations, &poses, &report.iterations, &report.usable);
  if (options.doubt && problem.has_loops() &&
      weight_of(config, largest_error(problem, poses)) < kDoubted) {
    Poses graduated = problem.start();
    const double cost =
        solve_graduated(config, options.max_iterations, &problem, &graduated, &report);
    if (cost < report.final_cost) {
      report.final_cost = cost;
      poses = std::move(graduated);
    }
  }
  if (!report.usable || report.final_cost > report.initial_cost) return report;

  problem.write_back(poses, nodes);
  report.loop_errors = problem.loop_errors(poses);
  for (const auto& [edge, error] : report.loop_errors) {
    (*edges)[edge].loop_weight = weight_of(config, error);
    if ((*edges)[edge].loop_weight < 0.1) ++report.loops_outvoted;
  }
  return report;
}

double edge_error(const PoseGraphConfig& config, bool planar, const GraphNodes& nodes,
                  const GraphEdge& edge) {
  const Vector6d error =
      relative_pose_error(nodes.at(edge.from).T_map_base, nodes.at(edge.to).T_map_base,
                          edge.adjusted ? *edge.adjusted : edge.T_from_to, nullptr, nullptr);
  return (sqrt_information(effective_covariance(config.noise, edge, planar)) * error).squaredNorm();
}

}  // namespace fusion_slam
