#include "libs/graph/uncertainty.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <tuple>

#include "libs/graph/edge_noise.hpp"

namespace fusion_slam {
namespace {

// A radian of doubt moves what is this far away.
constexpr double kLever_m = 5.0;

constexpr int kStart = -1;
constexpr int kUnreachable = -2;

}  // namespace

int GraphUncertainty::index_of(const NodeId& id) {
  const int next = free_nodes_.empty() ? static_cast<int>(neighbours_.size()) : free_nodes_.back();
  const auto [it, is_new] = index_.emplace(id, next);
  if (!is_new) return it->second;
  if (free_nodes_.empty())
    neighbours_.emplace_back();
  else
    free_nodes_.pop_back();
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
  put({a, b, T_from_to, covariance, length, is_loop ? EdgeIs::kLoop : EdgeIs::kLasting});
}

void GraphUncertainty::put(const Edge& edge) {
  int number = static_cast<int>(edges_.size());
  if (free_edges_.empty()) {
    edges_.push_back(edge);
  } else {
    number = free_edges_.back();
    free_edges_.pop_back();
    edges_[static_cast<std::size_t>(number)] = edge;
  }
  neighbours_[static_cast<std::size_t>(edge.from)].push_back({number, edge.to, edge.length});
  neighbours_[static_cast<std::size_t>(edge.to)].push_back({number, edge.from, edge.length});
}

void GraphUncertainty::remove(int edge) {
  const Edge& e = edges_[static_cast<std::size_t>(edge)];
  for (const int end : {e.from, e.to}) {
    std::vector<Arc>& all = neighbours_[static_cast<std::size_t>(end)];
    all.erase(
        std::remove_if(all.begin(), all.end(), [edge](const Arc& a) { return a.edge == edge; }),
        all.end());
  }
  free_edges_.push_back(edge);
}

void GraphUncertainty::remove_loops(const NodeId& from, const NodeId& to) {
  const auto a = index_.find(from);
  const auto b = index_.find(to);
  if (a == index_.end() || b == index_.end()) return;
  const std::vector<Arc> all = neighbours_[static_cast<std::size_t>(a->second)];
  for (const Arc& arc : all) {
    const Edge& edge = edges_[static_cast<std::size_t>(arc.edge)];
    if (edge.is == EdgeIs::kLoop && edge.from == a->second && edge.to == b->second)
      remove(arc.edge);
  }
}

std::map<int, GraphUncertainty::Spoke> GraphUncertainty::take_out(int node) {
  std::map<int, Spoke> spokes;
  const std::vector<Arc> all = neighbours_[static_cast<std::size_t>(node)];
  for (const Arc& arc : all) {
    Edge edge = edges_[static_cast<std::size_t>(arc.edge)];
    remove(arc.edge);
    if (edge.from == node)
      edge = {edge.to,
              node,
              edge.T_from_to.inverse(),
              inverse_covariance(edge.covariance, edge.T_from_to),
              edge.length,
              edge.is};
    Spoke& spoke = spokes.try_emplace(edge.from, Spoke{edge, false}).first->second;
    if (edge.length < spoke.edge.length) spoke.edge = edge;
    spoke.lasting = spoke.lasting || edge.is == EdgeIs::kLasting;
  }
  return spokes;
}

GraphUncertainty::Edge GraphUncertainty::through(const Edge& a, const Edge& b, EdgeIs is) {
  const SE3 T_gone_b = b.T_from_to.inverse();
  return {a.from,
          b.from,
          a.T_from_to * T_gone_b,
          chained_covariance(a.covariance, T_gone_b, inverse_covariance(b.covariance, b.T_from_to)),
          a.length + b.length,
          is};
}

// What edges that last had tied to the node stays tied to each other, at the nearest of them.
void GraphUncertainty::hold_together(const std::map<int, Spoke>& spokes,
                                     std::vector<Edge>* added) const {
  const Spoke* nearest = nullptr;
  for (const auto& [node, spoke] : spokes)
    if (spoke.lasting && (nearest == nullptr || spoke.edge.length < nearest->edge.length))
      nearest = &spoke;
  for (const auto& [node, spoke] : spokes)
    if (spoke.lasting && &spoke != nearest)
      added->push_back(through(nearest->edge, spoke.edge, EdgeIs::kLasting));
}

// No best path uses an edge that another path is shorter than.
void GraphUncertainty::remove_longer(int a, int b, double length) {
  const std::vector<Arc> all = neighbours_[static_cast<std::size_t>(a)];
  for (const Arc& arc : all) {
    const Edge& edge = edges_[static_cast<std::size_t>(arc.edge)];
    if (arc.other == b && edge.is != EdgeIs::kLasting && edge.length > length) remove(arc.edge);
  }
}

void GraphUncertainty::retire(const NodeId& node) {
  const auto found = index_.find(node);
  if (found == index_.end()) return;
  const std::map<int, Spoke> spokes = take_out(found->second);
  free_nodes_.push_back(found->second);
  index_.erase(found);

  std::vector<Edge> added;
  hold_together(spokes, &added);
  std::vector<std::tuple<int, int, double>> best;
  for (auto a = spokes.begin(); a != spokes.end(); ++a) {
    Paths around = from(a->first);
    for (auto b = std::next(a); b != spokes.end(); ++b) {
      const double length_through = a->second.edge.length + b->second.edge.length;
      const bool shorter = around.reach(b->first, length_through) &&
                           around.length_[static_cast<std::size_t>(b->first)] <= length_through;
      best.emplace_back(
          a->first, b->first,
          shorter ? around.length_[static_cast<std::size_t>(b->first)] : length_through);
      if (!shorter) added.push_back(through(a->second.edge, b->second.edge, EdgeIs::kShortcut));
    }
  }
  for (const auto& [a, b, length] : best) remove_longer(a, b, length);
  for (const Edge& edge : added) put(edge);
}

GraphUncertainty::Paths GraphUncertainty::from(const NodeId& start) const {
  const auto found = index_.find(start);
  return from(found == index_.end() ? kUnreachable : found->second);
}

GraphUncertainty::Paths GraphUncertainty::from(int start) const {
  Paths paths;
  paths.graph_ = this;
  paths.edge_to_.assign(neighbours_.size(), kUnreachable);
  paths.length_.assign(neighbours_.size(), std::numeric_limits<double>::infinity());
  paths.settled_.assign(neighbours_.size(), false);
  if (start < 0) return paths;
  paths.length_[static_cast<std::size_t>(start)] = 0.0;
  paths.edge_to_[static_cast<std::size_t>(start)] = kStart;
  paths.open_.emplace(0.0, start);
  return paths;
}

bool GraphUncertainty::Paths::reach(int node, double most) {
  while (!settled_[static_cast<std::size_t>(node)]) {
    if (open_.empty() || open_.top().first > most) return false;
    const auto [so_far, at] = open_.top();
    open_.pop();
    if (settled_[static_cast<std::size_t>(at)]) continue;
    settled_[static_cast<std::size_t>(at)] = true;
    for (const Arc& arc : graph_->neighbours_[static_cast<std::size_t>(at)]) {
      const double there = so_far + arc.length;
      if (there >= length_[static_cast<std::size_t>(arc.other)]) continue;
      length_[static_cast<std::size_t>(arc.other)] = there;
      edge_to_[static_cast<std::size_t>(arc.other)] = arc.edge;
      open_.emplace(there, arc.other);
    }
  }
  return true;
}

std::optional<GraphUncertainty::Paths::Relative> GraphUncertainty::Paths::to(const NodeId& node) {
  if (graph_ == nullptr) return std::nullopt;
  const auto found = graph_->index_.find(node);
  if (found == graph_->index_.end() || static_cast<std::size_t>(found->second) >= edge_to_.size() ||
      !reach(found->second, std::numeric_limits<double>::infinity()))
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
