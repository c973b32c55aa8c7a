#include "services/pose_graph/sparse_problem.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/OrderingMethods>

#include "libs/geometry/orthonormal.hpp"
#include "services/pose_graph/graph_costs.hpp"

namespace fusion_slam {
namespace {

constexpr double kFirstDamping = 1e-6;  // of the diagonal: nearly Gauss-Newton
constexpr double kMostDamping = 1e4;

}  // namespace

SparseProblem::SparseProblem(const PoseGraphConfig& config, const SolveOptions& options,
                             const GraphNodes& nodes, const std::vector<GraphEdge>& edges)
    : config_(config),
      planar_(options.planar),
      enough_(options.enough),
      unwanted_(options.unwanted) {
  const auto moves = [&](const NodeId& id) {
    return id != options.anchor && (options.moving.empty() || options.moving.count(id) > 0);
  };
  std::map<NodeId, int> index;
  for (const GraphEdge& edge : edges)
    for (const NodeId& id : {edge.from, edge.to})
      if (moves(id)) index.emplace(id, 0);
  for (auto& [id, variable] : index) {
    variable = static_cast<int>(variables_.size());
    variables_.push_back(id);
    start_.push_back(nodes.at(id).T_map_base);
  }
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const GraphEdge& edge = edges[i];
    const auto from = index.find(edge.from);
    const auto to = index.find(edge.to);
    if (from == index.end() && to == index.end()) continue;
    Term term;
    if (from != index.end())
      term.from = from->second;
    else
      term.T_from = nodes.at(edge.from).T_map_base;
    if (to != index.end())
      term.to = to->second;
    else
      term.T_to = nodes.at(edge.to).T_map_base;
    term.measured = edge.adjusted ? *edge.adjusted : edge.T_from_to;
    term.sqrt_information =
        sqrt_information(effective_covariance(config.noise, edge, options.planar));
    term.edge = i;
    term.loop = edge.kind == EdgeKind::kLoop;
    has_loops_ = has_loops_ || term.loop;
    terms_.push_back(term);
  }
}

int SparseProblem::variable_of(const NodeId& id) const {
  const auto found = std::lower_bound(variables_.begin(), variables_.end(), id);
  if (found == variables_.end() || *found != id) return -1;
  return static_cast<int>(found - variables_.begin());
}

// Which blocks the matrix has, in an order of elimination that keeps it sparse.
void SparseProblem::make_pattern() {
  const int n = n_variables();
  has_pattern_ = true;
  if (n == 0) return;
  std::set<std::pair<int, int>> pairs;
  for (const Term& term : terms_)
    if (term.from >= 0 && term.to >= 0)
      pairs.emplace(std::max(term.from, term.to), std::min(term.from, term.to));
  if (part_ != nullptr)
    for (const auto& [small, large] : part_->pairs())
      if (small != large) pairs.emplace(large, small);
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(static_cast<std::size_t>(n) + pairs.size());
  for (int i = 0; i < n; ++i) triplets.emplace_back(i, i, 1.0);
  for (const auto& [row, column] : pairs) triplets.emplace_back(row, column, 1.0);
  Eigen::SparseMatrix<double> pattern(n, n);
  pattern.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int> amd;
  amd(pattern.selfadjointView<Eigen::Lower>(), permutation);
  order_.assign(static_cast<std::size_t>(n), 0);
  for (int place = 0; place < n; ++place)
    order_[static_cast<std::size_t>(permutation.indices()[place])] = place;

  std::map<std::pair<int, int>, int> block_at;  // (column place, row place): column by column
  const auto place_of = [&](int variable) { return order_[static_cast<std::size_t>(variable)]; };
  for (int i = 0; i < n; ++i) block_at[{place_of(i), place_of(i)}] = 0;
  for (const auto& [a, b] : pairs)
    block_at[{std::min(place_of(a), place_of(b)), std::max(place_of(a), place_of(b))}] = 0;
  by_column_.resize(static_cast<std::size_t>(n));
  for (auto& [where, block] : block_at) {
    block = static_cast<int>(positions_.size());
    positions_.emplace_back(where.second, where.first);
    by_column_[static_cast<std::size_t>(where.first)].push_back(block);
  }
  blocks_.resize(positions_.size());
  for (int i = 0; i < n; ++i) diagonal_.push_back(block_at.at({place_of(i), place_of(i)}));
  for (Term& term : terms_) {
    if (term.from >= 0) term.block_from = diagonal_[static_cast<std::size_t>(term.from)];
    if (term.to >= 0) term.block_to = diagonal_[static_cast<std::size_t>(term.to)];
    if (term.from < 0 || term.to < 0) continue;
    const int f = place_of(term.from), t = place_of(term.to);
    term.block_cross = block_at.at({std::min(f, t), std::max(f, t)});
    term.cross_transposed = f > t;  // rows of the block are `from`'s
  }
  if (part_ != nullptr)
    for (const auto& [small, large] : part_->pairs()) {
      const int s = place_of(small), l = place_of(large);
      part_block_.push_back(block_at.at({std::min(s, l), std::max(s, l)}));
      part_transposed_.push_back(s < l ? 1 : 0);  // rows of the block are the larger one's
    }

  // The scalar matrix's pattern: full 6x6 blocks, diagonal ones included whole.
  Eigen::SparseMatrix<double>& H = equations_.H;
  H.resize(6 * n, 6 * n);
  Eigen::VectorXi sizes(6 * n);
  for (int column = 0; column < n; ++column)
    sizes.segment<6>(6 * column)
        .setConstant(6 * static_cast<int>(by_column_[static_cast<std::size_t>(column)].size()));
  H.reserve(sizes);
  for (int column = 0; column < n; ++column)
    for (int c = 0; c < 6; ++c)
      for (const int b : by_column_[static_cast<std::size_t>(column)])
        for (int r = 0; r < 6; ++r)
          H.insert(6 * positions_[static_cast<std::size_t>(b)].first + r, 6 * column + c) = 0.0;
  H.makeCompressed();
  gradient_.resize(6 * n);
}

Vector6d SparseProblem::error(const Term& term, const Poses& poses, Matrix6d* J_from,
                              Matrix6d* J_to) const {
  const SE3& T_from = term.from >= 0 ? poses[static_cast<std::size_t>(term.from)] : term.T_from;
  const SE3& T_to = term.to >= 0 ? poses[static_cast<std::size_t>(term.to)] : term.T_to;
  return relative_pose_error(T_from, T_to, term.measured, J_from, J_to);
}

double SparseProblem::cost(const Poses& poses, double mu) const {
  const GraduatedLoss loss(config_.loop_chi2, mu);
  double sum = 0.0;
  for (const Term& term : terms_) {
    const double s = (term.sqrt_information * error(term, poses, nullptr, nullptr)).squaredNorm();
    double rho[3] = {s, 1.0, 0.0};
    if (term.loop) loss.Evaluate(s, rho);
    sum += rho[0];
  }
  if (planar_)
    for (const SE3& T : poses)
      sum += planar_residual(config_.planar_z_m, config_.planar_tilt_rad, T, nullptr).squaredNorm();
  return 0.5 * sum + (part_ != nullptr ? part_->cost(poses) : 0.0);
}

std::vector<std::pair<std::size_t, double>> SparseProblem::loop_errors(const Poses& poses) const {
  std::vector<std::pair<std::size_t, double>> errors;
  for (const Term& term : terms_)
    if (term.loop)
      errors.emplace_back(
          term.edge, (term.sqrt_information * error(term, poses, nullptr, nullptr)).squaredNorm());
  return errors;
}

void SparseProblem::linearise(const Poses& poses, double mu) {
  const GraduatedLoss loss(config_.loop_chi2, mu);
  for (Matrix6d& block : blocks_) block.setZero();
  gradient_.setZero();
  Matrix6d J_from, J_to;
  for (const Term& term : terms_) {
    Vector6d e = term.sqrt_information * error(term, poses, &J_from, &J_to);
    double weight = 1.0;
    if (term.loop) {
      double rho[3];
      loss.Evaluate(e.squaredNorm(), rho);
      weight = rho[1];
    }
    const auto add = [&](int variable, int block, const Matrix6d& WJ) {
      blocks_[static_cast<std::size_t>(block)].noalias() += weight * (WJ.transpose() * WJ);
      gradient_.segment<6>(6 * order_[static_cast<std::size_t>(variable)]).noalias() +=
          weight * (WJ.transpose() * e);
    };
    const Matrix6d A = term.sqrt_information * J_from;
    const Matrix6d B = term.sqrt_information * J_to;
    if (term.from >= 0) add(term.from, term.block_from, A);
    if (term.to >= 0) add(term.to, term.block_to, B);
    if (term.block_cross < 0) continue;
    Matrix6d& cross = blocks_[static_cast<std::size_t>(term.block_cross)];
    if (term.cross_transposed)
      cross.noalias() += weight * (A.transpose() * B);
    else
      cross.noalias() += weight * (B.transpose() * A);
  }
  if (part_ != nullptr) add_part(poses);
  if (!planar_) return;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Eigen::Matrix<double, 3, 6> J;
    const Eigen::Vector3d e =
        planar_residual(config_.planar_z_m, config_.planar_tilt_rad, poses[i], &J);
    blocks_[static_cast<std::size_t>(diagonal_[i])] += J.transpose() * J;
    gradient_.segment<6>(6 * order_[i]) += J.transpose() * e;
  }
}

void SparseProblem::add_part(const Poses& poses) {
  part_->linearise(poses);
  for (std::size_t i = 0; i < part_block_.size(); ++i) {
    Matrix6d& block = blocks_[static_cast<std::size_t>(part_block_[i])];
    if (part_transposed_[i] != 0)
      block += part_->blocks()[i].transpose();
    else
      block += part_->blocks()[i];
  }
  for (std::size_t v = 0; v < poses.size(); ++v)
    gradient_.segment<6>(6 * order_[v]) += part_->gradient()[v];
}

void SparseProblem::fill(double damping) {
  double* value = equations_.H.valuePtr();
  for (std::size_t column = 0; column < by_column_.size(); ++column)
    for (int c = 0; c < 6; ++c)
      for (const int b : by_column_[column]) {
        const Matrix6d& block = blocks_[static_cast<std::size_t>(b)];
        const bool diagonal = positions_[static_cast<std::size_t>(b)].first ==
                              positions_[static_cast<std::size_t>(b)].second;
        for (int r = 0; r < 6; ++r)
          *value++ = block(r, c) * (diagonal && r == c ? 1.0 + damping : 1.0);
      }
}

double SparseProblem::minimise(double mu, int max_iterations, Poses* poses, int* iterations,
                               bool* usable) {
  if (!has_pattern_) make_pattern();
  double now = cost(*poses, mu);
  double damping = kFirstDamping;
  linearise(*poses, mu);
  for (int i = 0; i < max_iterations; ++i) {
    if (unwanted_ && *unwanted_) {
      *usable = false;
      return now;
    }
    ++*iterations;
    fill(damping);
    Eigen::VectorXd step;
    if (!equations_.solve(gradient_, &step)) {
      damping = std::max(1e-3, 10.0 * damping);
      if (damping > kMostDamping) {
        *usable = false;
        return now;
      }
      continue;
    }
    Poses next = *poses;
    std::vector<Vector6d> steps(next.size());
    for (std::size_t v = 0; v < next.size(); ++v) {
      steps[v] = -step.segment<6>(6 * order_[v]);
      next[v] = retract(next[v], steps[v]);
    }
    if (part_ != nullptr) part_->step(steps);
    const double then = cost(next, mu);
    if (!(then < now)) {
      if (part_ != nullptr) part_->drop();
      if (step.cwiseAbs().maxCoeff() < 1e-9 || damping > kMostDamping || then - now < 1e-12 * now)
        return now;
      damping *= 16.0;
      continue;
    }
    const double gain = now - then;
    *poses = std::move(next);
    now = then;
    damping = std::max(1e-9, damping / 8.0);
    if (gain < enough_ * now + 1e-12) return now;
    linearise(*poses, mu);
  }
  return now;
}

void SparseProblem::write_back(const Poses& poses, GraphNodes* nodes) const {
  for (std::size_t v = 0; v < variables_.size(); ++v)
    nodes->at(variables_[v]).T_map_base = orthonormal(poses[v]);
}

}  // namespace fusion_slam
