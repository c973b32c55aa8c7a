// A camera that had lost its way and found itself again in a place it knew: its word against the
// LiDAR's, which went on meanwhile.
#include "services/pose_graph/pose_graph.hpp"
#include "services/pose_graph/sensor_agreement.hpp"

namespace fusion_slam {

std::int64_t PoseGraph::utime_us(const NodeId& id) const {
  const auto retired = retired_.find(id);
  return retired != retired_.end() ? retired->second.utime_us : nodes_.at(id).utime_us;
}

// Of T_a_b in b's axes: along the best path of edges, an upper bound; nothing when none leads
// there.
std::optional<Matrix6d> PoseGraph::covariance_between(const NodeId& a, const NodeId& b) const {
  GraphUncertainty all = uncertainty();
  for (const NodeId& id : {a, b})
    if (const auto retired = retired_.find(id); retired != retired_.end())
      all.add_edge(retired->second.carrier, id, retired->second.T_carrier_base(),
                   retired->second.covariance());
  const auto path = all.from(a).to(b);
  if (!path) return std::nullopt;
  return path->covariance;
}

// False: the LiDAR may still say where that was.
bool PoseGraph::judge_found_again(const NodeInput& node, GraphEdge* edge, SE3* T_map_base) {
  const auto seen = lidar_.at(node.utime_us);
  if (!seen || !known(seen->pose.reference))
    return finishing_ || !may_still_come(NodeKind::kLidar, node.utime_us);
  const auto covariance = covariance_between(edge->from, seen->pose.reference);
  if (!covariance) return true;  // two maps that nothing joined until now
  const SE3 T_map_lidar = T_map(seen->pose.reference) * seen->pose.T_reference_base;
  const LidarSays lidar{T_map(edge->from).inverse() * T_map_lidar,
                        chained_covariance(*covariance, seen->pose.T_reference_base,
                                           interpolated_covariance(config_, *seen))};
  const auto doubted = doubted_covariance(config_.noise, *edge, lidar, robot_ && robot_->planar,
                                          config_.agreement_chi2);
  if (!doubted) return true;
  edge->covariance = *doubted;
  *T_map_base = T_map_lidar;
  ++counts_.edges_doubted;
  return true;
}

}  // namespace fusion_slam
