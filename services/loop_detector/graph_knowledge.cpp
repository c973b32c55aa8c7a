#include "services/loop_detector/graph_knowledge.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>

namespace fusion_slam {
namespace {

constexpr std::int64_t kTieGap_us = 1'000'000;
// Between a keyframe and the scan nearest in time the graph's own tie is finer; this is for
// telling places apart.
constexpr double kTieSigma_m = 0.02;
constexpr double kTieSigma_rad = 0.01;
// A track that starts anew with nothing to hang on can be anywhere near.
constexpr double kRestartSigma_m = 2.0;
constexpr double kRestartSigma_rad = 0.7;

Matrix6d diagonal(double sigma_m, double sigma_rad) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(sigma_m * sigma_m),
      Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return d.asDiagonal();
}

}  // namespace

void GraphKnowledge::remember(const NodeId& id, std::int64_t utime_us, const SE3& T_odom_base) {
  nodes_[id] = {utime_us, T_odom_base};
  std::int64_t& newest = newest_[id.kind];
  newest = std::max(newest, id.id);
}

void GraphKnowledge::add(const LoopKeyframe& keyframe) {
  const NodeId id{NodeKind::kKeyframe, keyframe.id};
  remember(id, keyframe.utime_us, keyframe.T_odom_base);
  if (keyframe.previous_id == 0) return;
  const NodeId previous{NodeKind::kKeyframe, keyframe.previous_id};
  const GraphEdge edge{EdgeKind::kVisual,   previous, id, keyframe.T_previous_base,
                       keyframe.covariance, 1.0};
  edges_.add_edge(previous, id, edge.T_from_to, effective_covariance(noise_, edge, planar_));
}

void GraphKnowledge::add(const LoopScan& scan) {
  const NodeId id{NodeKind::kLidar, scan.id};
  remember(id, scan.utime_us, scan.T_odom_base);
  scans_by_time_[scan.utime_us] = id;
  if (scan.previous_id == 0) return;
  const NodeId previous{NodeKind::kLidar, scan.previous_id};
  const GraphEdge edge{EdgeKind::kLidar, previous, id, scan.T_previous_base, scan.covariance, 1.0};
  edges_.add_edge(previous, id, edge.T_from_to, effective_covariance(noise_, edge, planar_));
}

bool GraphKnowledge::is_retired(const NodeId& id) const {
  const auto newest = newest_.find(id.kind);
  return newest != newest_.end() && id.id <= newest->second && nodes_.count(id) == 0;
}

void GraphKnowledge::moved(const NodeId& id, const SE3& T_map_base) {
  if (is_retired(id)) return;
  T_map_base_[id] = T_map_base;
  if (id.kind == NodeKind::kKeyframe) tie(id);
}

// Once both are in the graph: the edge between a keyframe and the scan of about its time.
void GraphKnowledge::tie(const NodeId& keyframe) {
  const auto node = nodes_.find(keyframe);
  if (node == nodes_.end() || tied_.count(keyframe) > 0) return;
  const auto scan = scan_near(node->second.utime_us, kTieGap_us);
  if (!scan || T_map_base_.count(*scan) == 0) return;
  tied_[keyframe] = true;
  const double gap_s =
      1e-6 * static_cast<double>(std::llabs(nodes_.at(*scan).utime_us - node->second.utime_us));
  edges_.add_edge(*scan, keyframe, T_map_base_.at(*scan).inverse() * T_map_base_.at(keyframe),
                  diagonal(kTieSigma_m + 0.1 * gap_s, kTieSigma_rad + 0.1 * gap_s));
}

void GraphKnowledge::add_loop(const LoopMeasurement& loop) {
  if (is_retired(loop.from) || is_retired(loop.to)) return;
  const GraphEdge edge{EdgeKind::kLoop, loop.from, loop.to, loop.T_from_to, loop.covariance, 1.0};
  edges_.add_edge(loop.from, loop.to, loop.T_from_to, effective_covariance(noise_, edge, planar_),
                  true);
}

void GraphKnowledge::remove_loop(const NodeId& from, const NodeId& to) {
  edges_.remove_loops(from, to);
}

void GraphKnowledge::retire(const NodeId& id) {
  const auto node = nodes_.find(id);
  if (node == nodes_.end()) return;
  edges_.retire(id);
  const auto scan = scans_by_time_.find(node->second.utime_us);
  if (scan != scans_by_time_.end() && scan->second == id) scans_by_time_.erase(scan);
  T_map_base_.erase(id);
  tied_.erase(id);
  nodes_.erase(node);
}

std::optional<SE3> GraphKnowledge::T_map_base(const NodeId& id) const {
  const auto node = nodes_.find(id);
  if (node == nodes_.end()) return std::nullopt;
  const auto known = T_map_base_.upper_bound(id);
  if (known == T_map_base_.begin()) return node->second.T_odom_base;
  const auto& [near, T_map_near] = *std::prev(known);
  if (near == id) return T_map_near;
  const auto anchor = nodes_.find(near);
  if (near.kind != id.kind || anchor == nodes_.end()) return node->second.T_odom_base;
  return T_map_near * anchor->second.T_odom_base.inverse() * node->second.T_odom_base;
}

std::optional<NodeId> GraphKnowledge::scan_near(std::int64_t utime_us,
                                                std::int64_t max_gap_us) const {
  auto after = scans_by_time_.lower_bound(utime_us);
  std::optional<NodeId> best;
  std::int64_t best_gap_us = max_gap_us;
  if (after != scans_by_time_.end() && after->first - utime_us <= best_gap_us) {
    best = after->second;
    best_gap_us = after->first - utime_us;
  }
  if (after != scans_by_time_.begin() && utime_us - std::prev(after)->first <= best_gap_us)
    best = std::prev(after)->second;
  return best;
}

std::vector<NodeId> GraphKnowledge::scans_near(std::int64_t utime_us,
                                               std::int64_t max_gap_us) const {
  std::vector<NodeId> scans;
  for (auto it = scans_by_time_.lower_bound(utime_us - max_gap_us);
       it != scans_by_time_.end() && it->first <= utime_us + max_gap_us; ++it)
    scans.push_back(it->second);
  return scans;
}

std::optional<std::int64_t> GraphKnowledge::utime_us(const NodeId& id) const {
  const auto node = nodes_.find(id);
  if (node == nodes_.end()) return std::nullopt;
  return node->second.utime_us;
}

std::optional<GraphKnowledge::Relative> GraphKnowledge::relative(const NodeId& from,
                                                                 const NodeId& to) const {
  GraphUncertainty::Paths paths = paths_from(from);
  return relative(&paths, from, to);
}

std::optional<GraphKnowledge::Relative> GraphKnowledge::relative(GraphUncertainty::Paths* paths,
                                                                 const NodeId& from,
                                                                 const NodeId& to) const {
  const auto T_map_from = T_map_base(from);
  const auto T_map_to = T_map_base(to);
  if (!T_map_from || !T_map_to) return std::nullopt;
  Relative result;
  result.T_from_to = T_map_from->inverse() * *T_map_to;
  if (const auto path = paths->to(to)) {
    result.covariance = path->covariance;
  } else {
    result.connected = false;
    result.covariance = diagonal(kRestartSigma_m, kRestartSigma_rad);
  }
  return result;
}

}  // namespace fusion_slam
