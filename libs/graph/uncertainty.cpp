#include "libs/graph/uncertainty.hpp"

#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "libs/graph/edge_noise.hpp"

namespace fusion_slam {
namespace {

// A radian of doubt moves what is this far away.
constexpr double kLever_m = 5.0;

constexpr int kStart = -1;
constexpr int kUnreachable = -2;

}  // namespace

int GraphUncertainty::index_of(const NodeId& id) {
  const auto [it, is_new] = index_.emplace(id, static_cast<int>(neighbours_.size()));
  if (is_new) neighbours_.emplace_back();
  return it->second;
}

void GraphUncertainty::add_edge(const NodeId& from, const NodeId& to, const SE3& T_from_to,
                                const Matrix6d& covariance, bool is_loop) {
  if (from == to || !covariance.allFinite() || !T_from_to.matrix().allFinite()) return;
  const double length = covariance.diagonal().head<3>().sum() +
                        kLever_m * kLever_m * covariance.diagonal().tail<3>().sum();
  if (length < 0.0) return;
  const int a = index_of(from);
  const int b = index_of(to);
  const int edge = static_cast<int>(edges_.size());
  edges_.push_back({a, b, T_from_to, covariance, length, is_loop, false});
  neighbours_[static_cast<std::size_t>(a)].push_back(edge);
  neighbours_[static_cast<std::size_t>(b)].push_back(edge);
}

void GraphUncertainty::remove_loops(const NodeId& from, const NodeId& to) {
  const auto a = index_.find(from);
  const auto b = index_.find(to);
  if (a == index_.end() || b == index_.end()) return;
  for (const int e : neighbours_[static_cast<std::size_t>(a->second)]) {
    Edge& edge = edges_[static_cast<std::size_t>(e)];
    if (edge.is_loop && edge.from == a->second && edge.to == b->second) edge.gone = true;
  }
}

GraphUncertainty::Paths GraphUncertainty::from(const NodeId& start) const {
  Paths paths;
  paths.graph_ = this;
  paths.edge_to_.assign(neighbours_.size(), kUnreachable);
  const auto found = index_.find(start);
  if (found == index_.end()) return paths;

  std::vector<double> length(neighbours_.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;  // ties: the smaller index first, so the same every time
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  length[static_cast<std::size_t>(found->second)] = 0.0;
  paths.edge_to_[static_cast<std::size_t>(found->second)] = kStart;
  open.emplace(0.0, found->second);
  while (!open.empty()) {
    const auto [so_far, node] = open.top();
    open.pop();
    if (so_far > length[static_cast<std::size_t>(node)]) continue;
    for (const int e : neighbours_[static_cast<std::size_t>(node)]) {
      const Edge& edge = edges_[static_cast<std::size_t>(e)];
      if (edge.gone) continue;
      const int other = edge.from == node ? edge.to : edge.from;
      const double there = so_far + edge.length;
      if (there >= length[static_cast<std::size_t>(other)]) continue;
      length[static_cast<std::size_t>(other)] = there;
      paths.edge_to_[static_cast<std::size_t>(other)] = e;
      open.emplace(there, other);
    }
  }
  return paths;
}

std::optional<GraphUncertainty::Paths::Relative> GraphUncertainty::Paths::to(
    const NodeId& node) const {
  if (graph_ == nullptr) return std::nullopt;
  const auto found = graph_->index_.find(node);
  if (found == graph_->index_.end() || static_cast<std::size_t>(found->second) >= edge_to_.size() ||
      edge_to_[static_cast<std::size_t>(found->second)] == kUnreachable)
    return std::nullopt;

  std::vector<std::pair<int, int>> steps;  // (edge, the node it leads to), last first
  for (int at = found->second; edge_to_[static_cast<std::size_t>(at)] != kStart;) {
    const int e = edge_to_[static_cast<std::size_t>(at)];
    steps.emplace_back(e, at);
    const Edge& edge = graph_->edges_[static_cast<std::size_t>(e)];
    at = edge.from == at ? edge.to : edge.from;
  }
  Relative relative;
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
    const Edge& edge = graph_->edges_[static_cast<std::size_t>(step->first)];
    const bool forward = edge.to == step->second;
    const SE3 T = forward ? edge.T_from_to : edge.T_from_to.inverse();
    const Matrix6d covariance =
        forward ? edge.covariance : inverse_covariance(edge.covariance, edge.T_from_to);
    relative.covariance = chained_covariance(relative.covariance, T, covariance);
    relative.T_start_node = relative.T_start_node * T;
  }
  return relative;
}

}  // namespace fusion_slam
