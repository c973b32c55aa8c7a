// How well a node's place in the map is known.
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

// All edges that are not outvoted.
GraphUncertainty PoseGraph::uncertainty() const {
  GraphUncertainty uncertainty;
  for (const GraphEdge& edge : edges_)
    if (edge.loop_weight >= 0.1)
      uncertainty.add_edge(edge.from, edge.to, edge.T_from_to,
                           effective_covariance(config_.noise, edge, robot_ && robot_->planar));
  return uncertainty;
}

// Relative to the map's origin, the oldest node: along the best path of edges (an upper bound; see
// libs/graph/uncertainty.hpp), in the node's axes. From the node before it where that is known, so
// that the whole graph is looked at only once after each solve.
Matrix6d PoseGraph::map_covariance(const NodeId& id) const {
  const auto retired = retired_.find(id);
  if (retired != retired_.end()) {
    const Retired& r = retired->second;
    return chained_covariance(map_covariance(r.carrier), r.T_carrier_base(), r.covariance());
  }
  const auto known_already = map_covariance_.find(id);
  if (known_already != map_covariance_.end()) return known_already->second;
  const bool planar = robot_ && robot_->planar;
  for (auto edge = edges_.rbegin(); edge != edges_.rend(); ++edge) {
    if (edge->to != id) continue;
    const auto before = map_covariance_.find(edge->from);
    if (before == map_covariance_.end()) break;
    return map_covariance_[id] = chained_covariance(
               before->second, edge->T_from_to, effective_covariance(config_.noise, *edge, planar));
  }
  const GraphUncertainty all = uncertainty();
  const auto path = all.from(by_time_.begin()->second).to(id);
  return map_covariance_[id] = path ? path->covariance : Matrix6d(Matrix6d::Zero());
}

}  // namespace fusion_slam
