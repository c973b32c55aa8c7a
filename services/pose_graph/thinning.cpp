#include "services/pose_graph/thinning.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "libs/geometry/orthonormal.hpp"

namespace fusion_slam {
namespace {

const NodeId& other_end(const GraphEdge& edge, const NodeId& id) {
  return edge.from == id ? edge.to : edge.from;
}

// What effective_covariance() makes `believed` of.
Matrix6d as_said(const EdgeNoiseConfig& config, const GraphEdge& edge, const Matrix6d& believed) {
  GraphEdge unit = edge;
  unit.kind =
      edge.kind == EdgeKind::kLidar || edge.kind == EdgeKind::kTie ? EdgeKind::kLidar : edge.kind;
  unit.covariance.setZero();
  unit.covariance(0, 0) = 1.0;
  const double floor = config.floor_translation_m * config.floor_translation_m;
  const double factor = effective_covariance(config, unit, true)(0, 0) - floor;
  Matrix6d said = believed;
  said.diagonal().head<3>().array() -= floor;
  said.diagonal().tail<3>().array() -= config.floor_rotation_rad * config.floor_rotation_rad;
  return said / factor;
}

}  // namespace

std::optional<GraphEdge> at_carrier(const PoseGraphConfig& config, bool planar,
                                    const GraphEdge& edge, const Retirement& retirement) {
  if (other_end(edge, retirement.id) == retirement.carrier) return std::nullopt;
  const Matrix6d believed = effective_covariance(config.noise, edge, planar);
  GraphEdge moved = edge;
  if (moved.said_from.id == 0) {
    moved.said_from = edge.from;
    moved.said_to = edge.to;
  }
  const SE3& T = retirement.T_carrier_base;
  Matrix6d chained;
  if (edge.from == retirement.id) {
    moved.from = retirement.carrier;
    moved.T_from_to = orthonormal(T * edge.T_from_to);
    if (edge.adjusted) moved.adjusted = orthonormal(T * *edge.adjusted);
    chained = chained_covariance(retirement.covariance, edge.T_from_to, believed);
  } else {
    const SE3 T_base_carrier = T.inverse();
    moved.to = retirement.carrier;
    moved.T_from_to = orthonormal(edge.T_from_to * T_base_carrier);
    if (edge.adjusted) moved.adjusted = orthonormal(*edge.adjusted * T_base_carrier);
    chained =
        chained_covariance(believed, T_base_carrier, inverse_covariance(retirement.covariance, T));
  }
  moved.covariance = as_said(config.noise, moved, chained);
  return moved;
}

Thinning::Thinning(const PoseGraphConfig& config, bool planar, std::vector<GraphEdge>* edges)
    : config_(config), planar_(planar), edges_(edges), gone_(edges->size(), 0) {
  for (std::size_t i = 0; i < edges->size(); ++i) {
    at_[(*edges)[i].from].push_back(i);
    at_[(*edges)[i].to].push_back(i);
  }
}

double Thinning::doubt(std::size_t edge) const {
  return effective_covariance(config_.noise, (*edges_)[edge], planar_).trace();
}

std::optional<NodeId> Thinning::carrier_of(const NodeId& id,
                                           const std::function<bool(const NodeId&)>& may) const {
  const auto found = at_.find(id);
  if (found == at_.end()) return std::nullopt;
  const double sigma_m = config_.thinning.carrier_sigma_m;
  double least = sigma_m * sigma_m;
  std::optional<NodeId> best;
  for (const std::size_t i : found->second) {
    const GraphEdge& edge = (*edges_)[i];
    if (gone_[i] != 0 || edge.loop_weight < 0.5 || !may(other_end(edge, id))) continue;
    const double d = doubt(i);
    if (d >= least) continue;
    least = d;
    best = other_end(edge, id);
  }
  return best;
}

std::optional<std::size_t> Thinning::best_between(const NodeId& a, const NodeId& b) const {
  std::optional<std::size_t> best;
  const auto found = at_.find(a);
  if (found == at_.end()) return best;
  for (const std::size_t i : found->second)
    if (gone_[i] == 0 && other_end((*edges_)[i], a) == b && (!best || doubt(i) < doubt(*best)))
      best = i;
  return best;
}

bool Thinning::retire(Retirement* retirement) {
  const auto joint = best_between(retirement->id, retirement->carrier);
  if (!joint) return false;
  const GraphEdge& edge = (*edges_)[*joint];
  const bool forward = edge.to == retirement->id;
  const Matrix6d believed = effective_covariance(config_.noise, edge, planar_);
  const SE3& measured = edge.adjusted ? *edge.adjusted : edge.T_from_to;
  retirement->covariance = forward ? believed : inverse_covariance(believed, measured);

  std::vector<std::size_t> mine;
  for (const std::size_t i : at_.at(retirement->id))
    if (gone_[i] == 0) mine.push_back(i);
  Retirement step = *retirement;
  if (mine.size() == 2) step.T_carrier_base = forward ? measured : SE3(measured.inverse());
  for (const std::size_t i : mine) {
    if (const auto moved = at_carrier(config_, planar_, (*edges_)[i], step)) {
      (*edges_)[i] = *moved;
      at_[retirement->carrier].push_back(i);
    } else {
      gone_[i] = 1;
    }
  }
  at_.erase(retirement->id);
  return true;
}

std::vector<std::ptrdiff_t> Thinning::finish() {
  std::map<std::tuple<NodeId, NodeId, EdgeKind>, std::size_t> best;
  for (std::size_t i = 0; i < edges_->size(); ++i) {
    const GraphEdge& edge = (*edges_)[i];
    if (gone_[i] != 0 || edge.said_from.id == 0) continue;
    const auto [low, high] = std::minmax(edge.from, edge.to);
    const auto [held, is_new] = best.emplace(std::make_tuple(low, high, edge.kind), i);
    if (is_new) continue;
    const bool better = doubt(i) < doubt(held->second);
    gone_[better ? held->second : i] = 1;
    if (better) held->second = i;
  }
  std::vector<std::ptrdiff_t> number(edges_->size(), -1);
  std::vector<GraphEdge> kept;
  for (std::size_t i = 0; i < edges_->size(); ++i) {
    if (gone_[i] != 0) continue;
    number[i] = static_cast<std::ptrdiff_t>(kept.size());
    kept.push_back(std::move((*edges_)[i]));
  }
  *edges_ = std::move(kept);
  return number;
}

}  // namespace fusion_slam
