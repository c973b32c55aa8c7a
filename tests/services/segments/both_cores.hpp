// Loop detector and pose graph as their processes join them: nodes go to both, accepted closures to
// the graph, what the graph moves or switches off back to the detector.
#pragma once

#include <vector>

#include "services/loop_detector/loop_detector.hpp"
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

struct BothCores {
  LoopDetector detector;
  PoseGraph graph;
  std::vector<LoopCandidate> accepted;
  std::vector<LoopCandidate> rejected;

  explicit BothCores(const RobotModel& robot) : detector(robot) { graph.set_robot(robot); }

  void add(const LoopKeyframe& keyframe) {
    add_node({NodeKind::kKeyframe, keyframe.id}, keyframe);
    take(detector.add(keyframe));
  }
  void add(const LoopScan& scan) {
    add_node({NodeKind::kLidar, scan.id}, scan);
    take(detector.add(scan));
  }
  void lost(NodeKind sensor, std::int64_t utime_us) {
    PoseInput pose;
    pose.sensor = sensor;
    pose.utime_us = utime_us;
    pose.state = PoseState::kLost;
    pose.reason = "covered by hand";
    graph.add_pose(pose);
  }
  void finish() {
    take(detector.finish());
    graph.finish();
    pass_on();
  }

 private:
  // KEYFRAME or LIDAR_NODE, and the pose of the same time.
  template <class Node>
  void add_node(const NodeId& id, const Node& from) {
    NodeInput node;
    node.id = id;
    node.utime_us = from.utime_us;
    node.T_odom_base = from.T_odom_base;
    node.previous_id = from.previous_id;
    node.T_previous_base = from.T_previous_base;
    node.covariance = from.covariance;
    graph.add_node(node);
    PoseInput pose;
    pose.sensor = id.kind;
    pose.utime_us = pose.fix_utime_us = from.utime_us;
    pose.T_odom_base = from.T_odom_base;
    pose.covariance = from.covariance;
    pose.state = PoseState::kOk;
    pose.reference = id;
    graph.add_pose(pose);
    pass_on();
  }
  void take(const std::vector<LoopCandidate>& decided) {
    for (const LoopCandidate& candidate : decided) {
      (candidate.accepted ? accepted : rejected).push_back(candidate);
      if (!candidate.accepted) continue;
      for (const LoopMeasurement& m : candidate.measurements)
        graph.add_loop({m.from, m.to, m.T_from_to, m.covariance, m.same_features});
    }
    pass_on();
  }
  void pass_on() {
    for (const auto& [id, node] : graph.take_changes()) detector.moved(id, node.T_map_base);
    for (const LoopState& off : graph.switched_off()) detector.switched_off(off.from, off.to);
  }
};

}  // namespace fusion_slam
