#include "logplayer/map_merge/joint_graph.hpp"

#include "bot_core/pose_t.hpp"
#include "libs/map_directory/decode.hpp"
#include "libs/messages/convert.hpp"
#include "services/pose_graph/graph_messages.hpp"

namespace fusion_slam {
namespace {

constexpr double kStart_m = 1.0;  // a start says little: the closures say where it is
constexpr double kStart_rad = 0.5;

}  // namespace

JointGraph::JointGraph(const RobotModel& robot) { graph_.set_robot(robot); }

void JointGraph::add_node(NodeInput node) {
  const auto start = starts_.find(node.id.kind);
  if (node.previous_id == 0 && start != starts_.end()) {
    node.previous_id = start->second.known.id;
    node.T_previous_base = start->second.T_known_base;
    node.covariance.setIdentity();
    node.covariance.topLeftCorner<3, 3>() *= kStart_m * kStart_m;
    node.covariance.bottomRightCorner<3, 3>() *= kStart_rad * kStart_rad;
    starts_.erase(start);
  }
  graph_.add_node(node);
}

void JointGraph::add(const LogEvent& event) {
  if (event.channel == "KEYFRAME") {
    if (const auto m = decode<keyframe_t>(event))
      if (const auto node = node_from(*m)) add_node(*node);
  } else if (event.channel == "LIDAR_NODE") {
    if (const auto m = decode<lidar_node_t>(event))
      if (const auto node = node_from(*m)) add_node(*node);
  } else if (event.channel == "VISUAL_POSE" || event.channel == "LIDAR_POSE") {
    const NodeKind sensor = event.channel == "LIDAR_POSE" ? NodeKind::kLidar : NodeKind::kKeyframe;
    if (const auto m = decode<pose_estimate_t>(event)) graph_.add_pose(pose_from(sensor, *m));
  } else if (event.channel == "ODOMETRY") {
    if (const auto m = decode<bot_core::pose_t>(event))
      if (const auto T = from_message(*m)) graph_.add_odometry(m->utime, *T);
  } else if (event.channel == "CONSTRAINT") {
    if (const auto m = decode<constraint_t>(event))
      if (const auto loop = loop_from(*m)) graph_.add_loop(*loop);
  } else if (event.channel == "LEVEL") {
    const auto m = decode<constraint_t>(event);
    const auto T = m ? from_message(m->T_from_to) : std::nullopt;
    if (T && is_node_kind(m->to_kind)) level({static_cast<NodeKind>(m->to_kind), m->to_id}, *T);
  }
  graph_.take_poses();
}

void JointGraph::start_track_at(NodeKind kind, const NodeId& known, const SE3& T_known_base) {
  starts_[kind] = {known, T_known_base};
}

void JointGraph::add_loop(const NodeId& from, const NodeId& to, const SE3& T_from_to,
                          const Matrix6d& covariance) {
  LoopInput loop;
  loop.from = from;
  loop.to = to;
  loop.T_from_to = T_from_to;
  loop.covariance = covariance;
  graph_.add_loop(loop);
}

bool JointGraph::level(const NodeId& id, const SE3& T_level_id) {
  std::string why;
  return graph_.level_map(id, T_level_id, &why);
}

void JointGraph::finish() {
  graph_.finish();
  graph_.take_poses();
}

}  // namespace fusion_slam
