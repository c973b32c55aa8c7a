// The whole map moved at once, so that z is up and z = 0 the floor.
#include "libs/geometry/orthonormal.hpp"
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

// A change of gauge: the solver never sees it as a constraint, because nothing in the graph speaks
// against it. Edges, tracks and loops are relative and stay as they are; the anchor of later solves
// stands where it stands now.
bool PoseGraph::level_map(const NodeId& id, const SE3& T_level_id, std::string* why) {
  if (!robot_ || robot_->planar || !known(id)) {
    if (!robot_)
      *why = "ROBOT_MODEL isn't known yet";
    else if (robot_->planar)
      *why = "a planar robot's map is level already";
    else
      *why = "node " + std::to_string(id.id) + " isn't in the graph";
    ++counts_.rejected;
    return false;
  }
  const SE3 T_level_map = levelling(T_map(id), T_level_id);
  for (auto& [node_id, node] : nodes_) {
    node.T_map_base = orthonormal(T_level_map * node.T_map_base);
    changed_.insert(node_id);
  }
  for (const auto& retired : retired_) changed_.insert(retired.first);
  for (auto& [carrier, load] : loads_) load.T_said = nodes_.at(carrier).T_map_base;
  for (auto* solve : {&background_, &quick_})
    if (*solve) (*solve)->T_now_then = T_level_map * (*solve)->T_now_then;
  if (last_pose_) last_pose_->T_map_base = T_level_map * last_pose_->T_map_base;
  taken_.clear();  // every node is handed out, however little it moved: all are in one map again
  ++counts_.levellings;
  return true;
}

}  // namespace fusion_slam
