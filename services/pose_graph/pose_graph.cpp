#include "services/pose_graph/pose_graph.hpp"

#include <algorithm>
#include <utility>

#include "libs/geometry/orthonormal.hpp"
#include "services/pose_graph/sensor_agreement.hpp"

namespace fusion_slam {
PoseGraph::PoseGraph(PoseGraphConfig config)
    : config_(std::move(config)),
      visual_(config_.max_interpolation_gap_us, config_.track_memory_us),
      lidar_(config_.max_interpolation_gap_us, config_.track_memory_us),
      odometry_(config_.max_interpolation_gap_us, config_.track_memory_us) {}

void PoseGraph::set_robot(const RobotModel& robot) { robot_ = robot; }

void PoseGraph::set_camera(const CameraModel& camera) { camera_ = camera; }

void PoseGraph::add_node(const NodeInput& node) {
  const auto key = std::make_pair(node.utime_us, node.id);
  if (node.id.id <= 0 || known(node.id) || waiting_nodes_.count(key) > 0) {
    ++counts_.rejected;
    return;
  }
  waiting_nodes_[key] = node;
  newest_utime_us_ = std::max(newest_utime_us_, node.utime_us);
  settle();
}

void PoseGraph::add_pose(const PoseInput& pose) {
  const bool usable = pose.state == PoseState::kOk || pose.state == PoseState::kWeak;
  if (usable && pose.reference)
    track(pose.sensor)
        .add({pose.utime_us, pose.T_odom_base, *pose.reference, pose.T_reference_base,
              pose.covariance, pose.fix_utime_us, false});
  else
    track(pose.sensor).mark_break();
  waiting_poses_.push_back(pose);
  newest_utime_us_ = std::max(newest_utime_us_, pose.utime_us);
  settle();
}

void PoseGraph::clock_was_set_back(std::int64_t utime_us) {
  constexpr std::int64_t kBack_us = 1'000'000;  // by less: what is there came since, by another
  for (PoseTrack* track : {&visual_, &lidar_, &odometry_})
    if (track->reaches(utime_us + kBack_us)) track->forget_from(utime_us);
  waiting_ties_.erase(waiting_ties_.lower_bound({utime_us + kBack_us, NodeId{}}),
                      waiting_ties_.end());
  newest_utime_us_ = std::min(newest_utime_us_, utime_us + kBack_us);
  rest_until_us_ = quick_rest_until_us_ = 0;
  if (last_pose_) last_pose_->utime_us = std::min(last_pose_->utime_us, utime_us);
}

void PoseGraph::add_odometry(std::int64_t utime_us, const SE3& T_odom_base) {
  constexpr std::int64_t kBack_us = 1'000'000;  // odometry is not sent again: no message is late
  if (odometry_.reaches(utime_us + kBack_us)) odometry_.forget_from(utime_us);
  TrackPose pose;
  pose.utime_us = utime_us;
  pose.T_odom_base = T_odom_base;
  odometry_.add(pose);
}

void PoseGraph::add_loop(const LoopInput& loop) {
  if (loop.from == loop.to || waiting_loops_.size() >= config_.max_waiting) {
    ++counts_.rejected;
    return;
  }
  waiting_loops_.push_back(loop);
  settle();
}

void PoseGraph::rebuild(Earlier earlier) {
  rebuilding_ = true;
  earlier_ = std::move(earlier.T_map_base);
  earlier_retired_ = std::move(earlier.retired);
  earlier_off_ = std::move(earlier.switched_off);
  for (auto& [id, node] : nodes_) {
    const auto moved = earlier_.find(id);
    if (moved != earlier_.end()) node.T_map_base = orthonormal(moved->second);
  }
  for (auto& [carrier, load] : loads_) load.T_said = nodes_.at(carrier).T_map_base;
  switch_off_as_before();
  taken_ = nodes_;
}

// Loops of restore() that were switched off since then; earlier_off_ keeps those that are to come.
void PoseGraph::switch_off_as_before() {
  std::vector<LoopState> to_come;
  for (LoopState& off : earlier_off_) {
    const bool known_to_be_off =
        std::any_of(switched_off_.begin(), switched_off_.end(),
                    [&](const LoopState& s) { return s.from == off.from && s.to == off.to; });
    const auto loop = std::find_if(edges_.begin(), edges_.end(), [&](const GraphEdge& e) {
      const bool as_said = e.said_from.id == 0;
      return e.kind == EdgeKind::kLoop && (as_said ? e.from : e.said_from) == off.from &&
             (as_said ? e.to : e.said_to) == off.to;
    });
    if (known_to_be_off) continue;
    if (loop == edges_.end()) {
      to_come.push_back(std::move(off));
      continue;
    }
    edges_.erase(loop);
    doubted_.clear();  // edges have new numbers
    same_points_.erase({off.from, off.to});
    switched_off_.push_back(std::move(off));
    ++counts_.loops_switched_off;
  }
  earlier_off_ = std::move(to_come);
}

void PoseGraph::rebuilt() {
  if (!std::exchange(rebuilding_, false)) return;
  earlier_.clear();
  earlier_retired_.clear();
  earlier_off_.clear();
  retirements_.clear();  // the journal has them
  quick_wanted_ = false;
  if (unsolved_loops_ > 0) start_global_solve(false);
  unsolved_loops_ = 0;
}

void PoseGraph::start_anew() {
  PoseGraph fresh(config_);
  fresh.rebuilding_ = rebuilding_;
  fresh.earlier_ = std::move(earlier_);
  fresh.earlier_retired_ = std::move(earlier_retired_);
  fresh.earlier_off_ = std::move(earlier_off_);
  fresh.robot_ = robot_;
  fresh.camera_ = camera_;
  *this = std::move(fresh);
}

void PoseGraph::finish() {
  finishing_ = true;
  quick_.reset();  // all is solved below
  meet_global_solve(true);
  settle();
  if (rebuilding_) {  // an earlier process solved it, and its nodes are where that put them
    finishing_ = false;
    return;
  }
  meet_global_solve(true);
  // Twice: loops that don't fit in the first are switched off before the second.
  // The second ends with bundle adjustment when the camera has closed a loop.
  for (int round = 0; round < 2; ++round) {
    start_global_solve(round == 1 && camera_ && robot_ && !same_points_.empty());
    meet_global_solve(true);
  }
  say_poses();
  finishing_ = false;
}

void PoseGraph::settle() {
  while (place_nodes()) {
  }
  if (tie_keyframes() && !rebuilding_) refine_window();
  meet_global_solve(false);
  meet_quick_solve();
  thin();
  if (take_loops()) quick_wanted_ = true;
  if (quick_wanted_ && !rebuilding_) solve_quickly();
  if (!rebuilding_ && bundle_is_due()) start_global_solve(true);
  if (!rebuilding_ && solve_wanted_) start_global_solve(false);
  say_poses();
}

bool PoseGraph::place_nodes() {
  for (auto it = waiting_nodes_.begin(); it != waiting_nodes_.end(); ++it) {
    if (!place(it->second)) continue;
    refine_edges(it->second);
    waiting_nodes_.erase(it);
    return true;
  }
  return false;
}

// False: what it hangs on hasn't come yet.
bool PoseGraph::place(const NodeInput& node) {
  const NodeId previous{node.id.kind, node.previous_id};
  if (node.previous_id != 0 && known(previous)) {
    const bool lidar = node.id.kind == NodeKind::kLidar;
    SE3 T_map_base = T_map(previous) * node.T_previous_base;
    GraphEdge edge{lidar ? EdgeKind::kLidar : EdgeKind::kVisual,
                   previous,
                   node.id,
                   node.T_previous_base,
                   node.covariance,
                   1.0};
    const bool found_again = !lidar && node.utime_us - utime_us(previous) > config_.agreement_us;
    if (found_again && !judge_found_again(node, &edge, &T_map_base)) return false;
    put(node, T_map_base);
    add_edge(edge);
    return true;
  }
  const bool may_wait = !finishing_ && waiting_nodes_.size() < config_.max_waiting &&
                        newest_utime_us_ - node.utime_us <= config_.max_wait_us;
  if (node.previous_id != 0 && may_wait) return false;
  if (nodes_.empty()) {
    put(node, SE3::Identity());
    return true;
  }
  const auto found = hang(node);
  if (!found) return false;
  if (found->counts_as_restart) ++counts_.restarts;
  put(node, T_map(found->edge.from) * found->edge.T_from_to);
  add_edge(found->edge);
  return true;
}

// What local bundle adjustment knows better now takes the place of what was said first; the next
// solve moves the nodes.
void PoseGraph::refine_edges(const NodeInput& node) {
  for (const NodeInput::Refined& refined : node.refined)
    for (GraphEdge& edge : edges_)
      if (edge.kind == EdgeKind::kVisual && edge.to == NodeId{node.id.kind, refined.id} &&
          edge.from.kind == node.id.kind && edge.said_from.id == 0) {
        edge.T_from_to = refined.T_previous_base;
        edge.adjusted.reset();
      }
}

void PoseGraph::put(const NodeInput& node, const SE3& T_map_base) {
  const auto earlier = earlier_.find(node.id);
  const SE3& T = earlier == earlier_.end() ? T_map_base : earlier->second;
  nodes_[node.id] = {node.utime_us, orthonormal(T), node.T_odom_base};
  by_time_.emplace(node.utime_us, node.id);
  ++n_placed_;
  changed_.insert(node.id);
  if (!node.seen.empty()) seen_.add(node.id.id, node.seen);
  if (node.id.kind == NodeKind::kKeyframe) waiting_ties_.emplace(node.utime_us, node.id);
  if (waiting_ties_.size() > config_.max_waiting) waiting_ties_.erase(waiting_ties_.begin());
}

// Each keyframe is also seen in the LiDAR's trajectory: at the same time the robot was at one place
// only. True: new ties.
bool PoseGraph::tie_keyframes() {
  bool tied = false;
  for (auto it = waiting_ties_.begin(); it != waiting_ties_.end();) {
    const auto& [utime_us, id] = *it;
    const auto seen = lidar_.at(utime_us);
    const bool usable = seen && known(seen->pose.reference);
    if (!usable && (seen || may_still_come(NodeKind::kLidar, utime_us)) && !finishing_) {
      ++it;
      continue;
    }
    if (usable) {
      add_edge({EdgeKind::kTie, seen->pose.reference, id, seen->pose.T_reference_base,
                interpolated_covariance(config_, *seen), 1.0});
      ++counts_.ties;
      tied = true;
      doubt_visual_edge(id);
    }
    it = waiting_ties_.erase(it);
  }
  return tied;
}

// The edge from a keyframe to its previous one, now that the LiDAR has gone the same way.
void PoseGraph::doubt_visual_edge(const NodeId& keyframe) {
  const auto edge = std::find_if(edges_.rbegin(), edges_.rend(), [&](const GraphEdge& e) {
    return e.kind == EdgeKind::kVisual && e.to == keyframe && e.said_from.id == 0;
  });
  const auto from = edge == edges_.rend() ? nodes_.end() : nodes_.find(edge->from);
  if (from == nodes_.end()) return;
  const std::int64_t from_us = from->second.utime_us, to_us = nodes_.at(keyframe).utime_us;
  if (to_us - from_us > config_.agreement_us) return;
  const auto motion = lidar_.motion(from_us, to_us);
  if (!motion) return;
  const LidarSays lidar{*motion, interpolated_covariance(config_, *lidar_.at(from_us)) +
                                     interpolated_covariance(config_, *lidar_.at(to_us))};
  const auto doubted = doubted_covariance(config_.noise, *edge, lidar, robot_ && robot_->planar,
                                          config_.agreement_chi2);
  if (!doubted) return;
  edge->covariance = *doubted;
  ++counts_.edges_doubted;
}

// True: the graph should be solved. A loop that agrees with the graph as it is can wait for others.
bool PoseGraph::take_loops() {
  bool pulls = false;
  std::vector<LoopInput> still_waiting;
  for (LoopInput& loop : waiting_loops_) {
    if (!known(loop.from) || !known(loop.to)) {
      still_waiting.push_back(std::move(loop));
      continue;
    }
    ++counts_.loops;
    if (was_switched_off(loop)) continue;
    const std::size_t n_edges = edges_.size();
    add_edge({EdgeKind::kLoop, loop.from, loop.to, loop.T_from_to, loop.covariance, 1.0});
    if (edges_.size() == n_edges) continue;  // between a node and who carries it
    ++unsolved_loops_;
    if (!loop.same_features.empty() && nodes_.count(loop.from) > 0 && nodes_.count(loop.to) > 0) {
      same_points_[{loop.from, loop.to}] = loop.same_features;
      ++new_visual_loops_;
    }
    const bool planar = robot_ && robot_->planar;
    pulls = pulls || edge_error(config_, planar, nodes_, edges_.back()) > config_.quiet_chi2;
  }
  waiting_loops_.swap(still_waiting);
  return unsolved_loops_ > 0 && (pulls || unsolved_loops_ >= config_.most_unsolved_loops);
}

// By an earlier process.
bool PoseGraph::was_switched_off(const LoopInput& loop) {
  const auto off = std::find_if(earlier_off_.begin(), earlier_off_.end(), [&](const LoopState& s) {
    return s.from == loop.from && s.to == loop.to;
  });
  if (off == earlier_off_.end()) return false;
  switched_off_.push_back(*off);
  ++counts_.loops_switched_off;
  earlier_off_.erase(off);
  return true;
}

// The newest nodes alone: between loops the two sensors' chains must not drift apart.
void PoseGraph::refine_window() {
  std::set<NodeId> moving;
  for (auto it = by_time_.rbegin(); it != by_time_.rend() && moving.size() < config_.window_nodes;
       ++it)
    moving.insert(it->second);
  solve(moving);
}

// From where the nodes are, a few steps: quick enough for between two scans. When loops don't fit,
// the whole graph is solved anew in the background.
void PoseGraph::solve(const std::set<NodeId>& moving) {
  if (nodes_.empty()) return;
  const SolveReport report = solve_graph(config_, quick_options(moving), &nodes_, &edges_);
  ++counts_.solves;
  for (const auto& [id, node] : nodes_)
    if (moving.empty() || moving.count(id) > 0) changed_.insert(id);
  if (!moving.empty()) return;
  map_covariance_.clear();
  unsolved_loops_ = 0;
  counts_.loops_outvoted = report.loops_outvoted;
  for (const auto& [edge, error] : report.loop_errors)
    if (error > config_.loop_chi2) return start_global_solve(false);
}

std::vector<std::pair<NodeId, GraphNode>> PoseGraph::take_changes() {
  std::vector<std::pair<NodeId, GraphNode>> changes;
  const auto moved = [](const SE3& before, const SE3& now, double m, double rad) {
    const Vector6d by = local(before, now);
    return by.head<3>().norm() >= m || by.tail<3>().norm() >= rad;
  };
  const auto carried = [this](const NodeId& id) {
    return GraphNode{retired_.at(id).utime_us, T_map(id), SE3::Identity()};
  };
  for (const NodeId& id : changed_) {
    const auto found = nodes_.find(id);
    if (found == nodes_.end()) {  // retired before it was handed out as it is
      changes.emplace_back(id, carried(id));
      continue;
    }
    const GraphNode& node = found->second;
    const auto load = loads_.find(id);
    if (load != loads_.end() && moved(load->second.T_said, node.T_map_base, 3e-3, 5e-4)) {
      load->second.T_said = node.T_map_base;
      for (const NodeId& other : load->second.ids) changes.emplace_back(other, carried(other));
    }
    const auto taken = taken_.find(id);
    if (taken != taken_.end() && !moved(taken->second.T_map_base, node.T_map_base, 1e-3, 1e-4))
      continue;
    taken_[id] = node;
    changes.emplace_back(id, node);
  }
  changed_.clear();
  if (!changes.empty()) ++revision_;
  return changes;
}

std::vector<std::pair<std::int64_t, Retirement>> PoseGraph::take_retirements() {
  return std::exchange(retirements_, {});
}

std::vector<PoseOutput> PoseGraph::take_poses() { return std::exchange(poses_, {}); }

}  // namespace fusion_slam
