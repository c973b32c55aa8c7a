#include "services/pose_graph/pose_graph_process.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "fusion_slam/graph_t.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "libs/process/memory.hpp"
#include "libs/process/priority.hpp"
#include "services/pose_graph/graph_messages.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kNodesPerPart = 400;          // 400 * 81 bytes: one datagram
constexpr std::int64_t kRevisionsPerComplete = 50;  // a listener that lost a message is whole again
constexpr std::size_t kSpareMemoryBytes = 16 << 20;
constexpr int kTellPeriodMs = 1000;  // live: and one that started late, too

PoseGraphConfig config_for(Mode mode) {
  PoseGraphConfig config;
  config.wait_for_solver = mode != Mode::kLive;  // a replay has no clock to keep
  if (mode == Mode::kLive) config.solver_begins = give_way;
  return config;
}

}  // namespace

PoseGraphProcess::PoseGraphProcess(Bus& bus) : bus_(bus), graph_(config_for(bus.mode())) {
  const auto on = [this](auto method) {
    return [this, method](const auto& message) {
      follow_recovery();
      (this->*method)(message);
      publish_news();
    };
  };
  bus.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kLatestOnly, on(&PoseGraphProcess::on_robot));
  bus.subscribe<camera_model_t>("CAMERA_MODEL", Policy::kLatestOnly,
                                on(&PoseGraphProcess::on_camera));
  bus.subscribe<keyframe_t>("KEYFRAME", Policy::kKeepAll, on(&PoseGraphProcess::on_keyframe));
  bus.subscribe<lidar_node_t>("LIDAR_NODE", Policy::kKeepAll, on(&PoseGraphProcess::on_lidar_node));
  bus.subscribe<constraint_t>("CONSTRAINT", Policy::kKeepAll, on(&PoseGraphProcess::on_constraint));
  bus.subscribe<constraint_t>("LEVEL", Policy::kKeepAll, on(&PoseGraphProcess::on_level));
  keep_journal();
  bus.subscribe<bot_core::pose_t>("ODOMETRY", Policy::kKeepAll, on(&PoseGraphProcess::on_odometry));
  bus.subscribe<command_t>("COMMAND", Policy::kKeepAll, on(&PoseGraphProcess::on_command));
  const auto on_pose_of = [this](NodeKind sensor) {
    return [this, sensor](const pose_estimate_t& message) {
      follow_recovery();
      on_pose(sensor, message);
      publish_news();
    };
  };
  bus.subscribe<pose_estimate_t>("VISUAL_POSE", Policy::kKeepAll, on_pose_of(NodeKind::kKeyframe));
  bus.subscribe<pose_estimate_t>("LIDAR_POSE", Policy::kKeepAll, on_pose_of(NodeKind::kLidar));
  // Nodes come before the poses of their time, from the same tracker; what is missing is waited for
  // where it is needed; and POSE must not wait for the slower sensor.
  bus.never_await(
      {"KEYFRAME", "LIDAR_NODE", "VISUAL_POSE", "LIDAR_POSE", "CONSTRAINT", "LEVEL", "COMMAND"});
  if (bus.mode() != Mode::kLive) return;
  bus.listen<status_t>("STATUS", [this](const status_t& m) {
    const auto [peer, is_new] = peers_.emplace(m.process + "@" + m.host, m.pid);
    if (is_new || std::exchange(peer->second, m.pid) != m.pid) newcomer_ = true;
  });
  bus.every(kTellPeriodMs, [this] {
    follow_recovery();
    publish_to_late_ones();
    // A solve of the whole graph takes many times what the graph does, for a moment.
    if (std::exchange(solves_, graph_.counts().solves) != graph_.counts().solves)
      give_back_memory(kSpareMemoryBytes);
  });
}

void PoseGraphProcess::on_robot(const robot_model_t& message) {
  std::string why;
  if (const auto robot = from_message(message, &why))
    graph_.set_robot(*robot);
  else
    reject("ROBOT_MODEL", why.c_str());
}

void PoseGraphProcess::on_camera(const camera_model_t& message) {
  std::string why;
  if (const auto camera = from_message(message, &why))
    graph_.set_camera(*camera);
  else
    reject("CAMERA_MODEL", why.c_str());
}

void PoseGraphProcess::on_keyframe(const keyframe_t& message) {
  if (!reset_.passes(message.utime)) return;
  if (const auto node = node_from(message))
    graph_.add_node(*node);
  else
    reject("KEYFRAME", "a pose is not a rigid motion");
}

void PoseGraphProcess::on_lidar_node(const lidar_node_t& message) {
  if (!reset_.passes(message.utime)) return;
  if (const auto node = node_from(message))
    graph_.add_node(*node);
  else
    reject("LIDAR_NODE", "a pose is not a rigid motion");
}

void PoseGraphProcess::on_pose(NodeKind sensor, const pose_estimate_t& message) {
  if (clock_[sensor].was_set_back(message.seq, message.utime)) {
    bus_.report_error("the robot's clock was set back to " + std::to_string(message.utime) + " us");
    graph_.clock_was_set_back(message.utime);
  }
  if (reset_.passes(message.utime)) graph_.add_pose(pose_from(sensor, message));
}

void PoseGraphProcess::on_odometry(const bot_core::pose_t& message) {
  if (const auto T_odom_base = from_message(message))
    graph_.add_odometry(message.utime, *T_odom_base);
  else
    reject("ODOMETRY", "the pose is not a rigid motion");
}

void PoseGraphProcess::on_constraint(const constraint_t& message) {
  if (!reset_.passes(message.utime)) return;
  if (const auto loop = loop_from(message))
    graph_.add_loop(*loop);
  else
    reject("CONSTRAINT", "the motion is not rigid or a node's kind does not exist");
}

// A prior on a node's z, roll and pitch. Its covariance says no more than that: the other three are
// free, so the smallest motion of the map satisfies it.
void PoseGraphProcess::on_level(const constraint_t& message) {
  if (!reset_.passes(message.utime)) return;
  const auto T_level_id = from_message(message.T_from_to);
  if (!T_level_id || message.from_kind != graph_node_t::MAP || !is_node_kind(message.to_kind))
    return reject("LEVEL", "the motion is not rigid, or not from the map to a node");
  std::string why;
  if (!graph_.level_map({static_cast<NodeKind>(message.to_kind), message.to_id}, *T_level_id, &why))
    reject("LEVEL", why.c_str());
}

void PoseGraphProcess::on_command(const command_t& message) {
  if (reset_.asks(message)) {
    graph_.start_anew();
    last_complete_ = 0;
    publish_complete();
    return say_state();
  }
  if (!message.target.empty() && message.target != "pose_graph") return;
  if (message.verb == "finish") {
    graph_.finish();
    publish_news();
    publish_complete();
  }
}

void PoseGraphProcess::publish_news() {
  std::vector<graph_node_t> changed;
  for (const auto& [id, node] : graph_.take_changes()) changed.push_back(to_message(id, node));
  if (!changed.empty()) {
    publish_graph(changed, false);
    const bool all_is_little = bus_.mode() != Mode::kLive || graph_.n_nodes() <= kNodesPerPart;
    if (all_is_little && graph_.revision() - last_complete_ >= kRevisionsPerComplete)
      publish_complete();
    say_state();
  }
  for (const auto& [n_placed, retirement] : graph_.take_retirements())
    bus_.note("RETIRED", to_message(retirement, graph_.newest_utime_us(), n_placed));
  for (const PoseOutput& pose : graph_.take_poses()) publish_pose(pose);
}

void PoseGraphProcess::publish_complete() {
  std::vector<graph_node_t> all;
  for (const auto& [id, node] : graph_.nodes_after({}, graph_.n_nodes()))
    all.push_back(to_message(id, node));
  publish_graph(all, true);
  last_complete_ = graph_.revision();
}

// All of a small graph; of a large one so much as fits into one message, each time what follows. To
// who has just started all at once.
void PoseGraphProcess::publish_to_late_ones() {
  if (newcomer_.exchange(false) || graph_.n_nodes() <= kNodesPerPart) return publish_complete();
  std::vector<graph_node_t> some;
  for (const auto& [id, node] : graph_.nodes_after(last_told_, kNodesPerPart)) {
    some.push_back(to_message(id, node));
    last_told_ = id;
  }
  if (some.size() < kNodesPerPart) last_told_ = {};
  publish_graph(some, false, false);
}

std::int64_t PoseGraphProcess::revision() const {
  return std::max(bus_.first_revision(), earlier_revision_) + graph_.revision();
}

void PoseGraphProcess::publish_graph(const std::vector<graph_node_t>& nodes, bool complete,
                                     bool is_news) {
  const std::size_t n_parts =
      std::max<std::size_t>(1, (nodes.size() + kNodesPerPart - 1) / kNodesPerPart);
  for (std::size_t part = 0; part < n_parts; ++part) {
    const auto begin = nodes.begin() + static_cast<std::ptrdiff_t>(part * kNodesPerPart);
    const auto end = nodes.begin() + static_cast<std::ptrdiff_t>(
                                         std::min(nodes.size(), (part + 1) * kNodesPerPart));
    graph_t message{};
    message.utime = graph_.newest_utime_us();
    message.revision = revision();
    message.complete = complete ? 1 : 0;
    message.part = static_cast<std::int32_t>(part);
    message.n_parts = static_cast<std::int32_t>(n_parts);
    message.nodes.assign(begin, end);
    message.n_nodes = static_cast<std::int32_t>(message.nodes.size());
    message.n_loops = static_cast<std::int32_t>(graph_.counts().loops);
    if (part == 0)
      for (const LoopState& loop : graph_.switched_off())
        message.switched_off.push_back(to_message(loop));
    message.n_switched_off = static_cast<std::int32_t>(message.switched_off.size());
    if (is_news && !complete) bus_.note("GRAPH", message);
    bus_.publish("GRAPH", message);
  }
}

void PoseGraphProcess::publish_pose(const PoseOutput& pose) {
  bus_.publish("POSE", to_message(pose));
}

void PoseGraphProcess::reject(const char* channel, const char* why) {
  bus_.report_error(std::string(channel) + ": " + why);
}

void PoseGraphProcess::say_state() {
  const PoseGraphCounts& n = graph_.counts();
  bus_.set_state_text(std::to_string(graph_.n_nodes()) + " nodes (" + std::to_string(n.retired) +
                      " carried by others), " + std::to_string(n.loops) + " loops (" +
                      std::to_string(n.loops_outvoted) + " outvoted), " + std::to_string(n.ties) +
                      " camera-LiDAR ties, " + std::to_string(n.edges_doubted) +
                      " camera edges doubted, " + std::to_string(n.restarts) + " restarts, " +
                      std::to_string(n.bundles) + " bundle adjustments" +
                      (n.bundles_refused > 0
                           ? " (" + std::to_string(n.bundles_refused) +
                                 " refused, last: " + graph_.last_bundle().reason + ")"
                           : std::string()));
}

}  // namespace fusion_slam
