// Which nodes leave the graph, and where they are from then on.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "libs/geometry/orthonormal.hpp"
#include "services/pose_graph/pose_graph.hpp"
#include "services/pose_graph/thinning.hpp"

namespace fusion_slam {
namespace {

// Nodes that stay, by place.
class Places {
 public:
  explicit Places(const ThinningConfig& config) : config_(config) {}
  void add(const NodeId& id, const SE3& T_map_base) {
    cells_[cell(id, T_map_base, 0, 0)].push_back(T_map_base);
  }
  bool has_enough(const NodeId& id, const SE3& T_map_base) const {
    int mates = 0;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy) {
        const auto found = cells_.find(cell(id, T_map_base, dx, dy));
        if (found == cells_.end()) continue;
        for (const SE3& T : found->second)
          mates += is_mate(T, T_map_base, id.kind == NodeKind::kLidar) ? 1 : 0;
      }
    return mates >= config_.enough;
  }

 private:
  using Cell = std::array<int, 3>;
  Cell cell(const NodeId& id, const SE3& T, int dx, int dy) const {
    const auto index = [&](int axis) {
      return static_cast<int>(std::floor(T.translation()[axis] / config_.within_m));
    };
    return {static_cast<int>(id.kind), index(0) + dx, index(1) + dy};
  }
  bool is_mate(const SE3& a, const SE3& b, bool lidar) const {
    const double far_m = (a.translation() - b.translation()).norm();
    if (lidar) return far_m <= config_.within_m;  // a scan sees all round, or nearly
    const double cosine = 0.5 * ((a.linear().transpose() * b.linear()).trace() - 1.0);
    return far_m <= config_.within_m && cosine >= std::cos(config_.within_rad);
  }

  const ThinningConfig& config_;
  std::map<Cell, std::vector<SE3>> cells_;
};

}  // namespace

// Not while the whole graph is being solved: the answer speaks of the edges as they were asked.
void PoseGraph::thin() {
  if (rebuilding_) return thin_as_before();
  if (background_ || finishing_ || n_placed_ < next_thinning_) return;
  next_thinning_ = n_placed_ + config_.thinning.every;
  const std::int64_t old_us = newest_utime_us_ - config_.thinning.after_us;
  std::set<NodeId> in_doubt;
  for (const GraphEdge& edge : edges_)
    if (edge.loop_weight < 0.5) in_doubt.insert({edge.from, edge.to});

  Places places(config_.thinning);
  std::set<NodeId> staying;
  std::vector<NodeId> superseded;
  for (const auto& [utime_us, id] : by_time_) {
    if (utime_us > old_us) break;
    const SE3& T = nodes_.at(id).T_map_base;
    if (!staying.empty() && in_doubt.count(id) == 0 && places.has_enough(id, T)) {
      superseded.push_back(id);
    } else {
      places.add(id, T);
      staying.insert(id);
    }
  }
  if (superseded.empty()) return;
  Thinning thinning(config_, robot_ && robot_->planar, &edges_);
  for (const NodeId& id : superseded) {
    const auto carrier =
        thinning.carrier_of(id, [&](const NodeId& other) { return staying.count(other) > 0; });
    if (carrier)
      retire(id, *carrier, nodes_.at(*carrier).T_map_base.inverse() * nodes_.at(id).T_map_base,
             &thinning);
    else
      staying.insert(id);
  }
  renumber(thinning.finish());
}

// An earlier process decided with the poses of then.
void PoseGraph::thin_as_before() {
  if (earlier_retired_.empty() || earlier_retired_.begin()->first > n_placed_) return;
  Thinning thinning(config_, robot_ && robot_->planar, &edges_);
  while (!earlier_retired_.empty() && earlier_retired_.begin()->first <= n_placed_) {
    for (const Retirement& r : earlier_retired_.begin()->second)
      if (nodes_.count(r.id) > 0 && nodes_.count(r.carrier) > 0)
        retire(r.id, r.carrier, r.T_carrier_base, &thinning);
    earlier_retired_.erase(earlier_retired_.begin());
  }
  renumber(thinning.finish());
}

void PoseGraph::retire(const NodeId& id, const NodeId& carrier, const SE3& T_carrier_base,
                       Thinning* thinning) {
  Retirement retirement{id, carrier, orthonormal(T_carrier_base), Matrix6d::Zero()};
  if (!thinning->retire(&retirement)) return;
  const auto node = nodes_.find(id);
  const Matrix6d& known = retirement.covariance;
  retired_[id] = {node->second.utime_us,
                  carrier,
                  retirement.T_carrier_base.translation(),
                  Eigen::Quaterniond(retirement.T_carrier_base.linear()),
                  static_cast<float>(known.topLeftCorner<3, 3>().trace()),
                  static_cast<float>(known.bottomRightCorner<3, 3>().trace())};
  const auto load = loads_.emplace(carrier, Load{nodes_.at(carrier).T_map_base, {}}).first;
  load->second.ids.push_back(id);
  hand_over_load(id);
  by_time_.erase({node->second.utime_us, id});
  nodes_.erase(node);
  taken_.erase(id);
  map_covariance_.erase(id);
  if (id.kind == NodeKind::kKeyframe) seen_.drop(id.id);
  for (auto it = same_points_.begin(); it != same_points_.end();)
    it = it->first.first == id || it->first.second == id ? same_points_.erase(it) : std::next(it);
  bundled_keyframes_ = std::min(bundled_keyframes_, seen_.n_keyframes());
  retirements_.emplace_back(n_placed_, retirement);
  ++counts_.retired;
}

// A node that carried others goes with them.
void PoseGraph::hand_over_load(const NodeId& id) {
  const auto load = loads_.find(id);
  if (load == loads_.end()) return;
  const Retired& own = retired_.at(id);
  const SE3 T_carrier_id = own.T_carrier_base();
  for (const NodeId& carried : load->second.ids) {
    Retired& r = retired_.at(carried);
    const SE3 T = orthonormal(T_carrier_id * r.T_carrier_base());
    r.carrier = own.carrier;
    r.t_carrier_base_m = T.translation();
    r.q_carrier_base = Eigen::Quaterniond(T.linear());
    r.translation_m2 += own.translation_m2;
    r.rotation_rad2 += own.rotation_rad2;
    loads_.at(own.carrier).ids.push_back(carried);
  }
  loads_.erase(load);
}

void PoseGraph::renumber(const std::vector<std::ptrdiff_t>& number) {
  std::map<std::size_t, int> doubted;
  for (const auto& [edge, times] : doubted_)
    if (number[edge] >= 0) doubted[static_cast<std::size_t>(number[edge])] = times;
  doubted_ = std::move(doubted);
}

// What is said of nodes that have retired is said of their carriers.
void PoseGraph::add_edge(GraphEdge edge) {
  for (const NodeId& id : {edge.from, edge.to}) {
    const auto retired = retired_.find(id);
    if (retired == retired_.end()) continue;
    const Retired& r = retired->second;
    const auto moved = at_carrier(config_, robot_ && robot_->planar, edge,
                                  {id, r.carrier, r.T_carrier_base(), r.covariance()});
    if (!moved) return;
    edge = *moved;
  }
  if (edge.from != edge.to) edges_.push_back(std::move(edge));
}

Matrix6d PoseGraph::Retired::covariance() const {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(translation_m2), Eigen::Vector3d::Constant(rotation_rad2);
  return variance.asDiagonal();
}

SE3 PoseGraph::Retired::T_carrier_base() const {
  SE3 T = SE3::Identity();
  T.linear() = q_carrier_base.toRotationMatrix();
  T.translation() = t_carrier_base_m;
  return T;
}

SE3 PoseGraph::T_map(const NodeId& id) const {
  const auto node = nodes_.find(id);
  if (node != nodes_.end()) return node->second.T_map_base;
  const Retired& r = retired_.at(id);
  return orthonormal(nodes_.at(r.carrier).T_map_base * r.T_carrier_base());
}

std::vector<std::pair<NodeId, GraphNode>> PoseGraph::nodes_after(const NodeId& id,
                                                                 std::size_t most) const {
  std::vector<std::pair<NodeId, GraphNode>> some;
  auto node = nodes_.upper_bound(id);
  auto retired = retired_.upper_bound(id);
  while (some.size() < most && (node != nodes_.end() || retired != retired_.end())) {
    const bool is_node =
        node != nodes_.end() && (retired == retired_.end() || node->first < retired->first);
    if (is_node) {
      some.emplace_back(*node++);
    } else {
      some.emplace_back(retired->first, GraphNode{retired->second.utime_us, T_map(retired->first),
                                                  SE3::Identity()});
      ++retired;
    }
  }
  return some;
}

}  // namespace fusion_slam
