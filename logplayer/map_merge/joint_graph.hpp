// One pose graph of all that two sessions measured, and of the closures between them.
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "libs/eventlog/event.hpp"
#include "libs/robot/robot_model.hpp"
#include "services/pose_graph/graph_types.hpp"
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

class JointGraph {
 public:
  explicit JointGraph(const RobotModel& robot);

  // KEYFRAME, LIDAR_NODE, VISUAL_POSE, LIDAR_POSE, ODOMETRY, CONSTRAINT, LEVEL in the order of
  // their times; others are ignored.
  void add(const LogEvent& event);
  // The next node that starts a track of its kind is put here, relative to a node that is known.
  void start_track_at(NodeKind kind, const NodeId& known, const SE3& T_known_base);
  void add_loop(const NodeId& from, const NodeId& to, const SE3& T_from_to,
                const Matrix6d& covariance);
  bool level(const NodeId& id, const SE3& T_level_id);
  void finish();

  const GraphNodes& nodes() const { return graph_.nodes(); }
  std::int64_t loops() const { return graph_.counts().loops; }
  const std::vector<LoopState>& switched_off() const { return graph_.switched_off(); }

 private:
  struct Start {
    NodeId known;
    SE3 T_known_base = SE3::Identity();
  };
  void add_node(NodeInput node);

  PoseGraph graph_;
  std::map<NodeKind, Start> starts_;
};

}  // namespace fusion_slam
