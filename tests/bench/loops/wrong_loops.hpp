// False closures put into the pose graph by hand, past the loop detector, and what becomes of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <map>
#include <utility>
#include <vector>

#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

class WrongLoops {
 public:
  WrongLoops() = default;
  // So many seconds after the graph's first node each; by_m: so far beside where the graph has the
  // newer node, 0: at the older node's place.
  explicit WrongLoops(std::vector<double> at_s, double by_m = 0.0)
      : at_s_(std::move(at_s)), by_m_(by_m) {
    std::sort(at_s_.begin(), at_s_.end());
  }

  // When it is time: a loop that says, good to 5 cm and 1 degree, that the newest node lies where
  // the robot was half the time ago (or by_m beside its true place, as a door further on).
  void inject(PoseGraph* graph) {
    if (next_ >= at_s_.size() || graph->nodes().empty()) return;
    if (start_us_ == 0) start_us_ = graph->nodes().begin()->second.utime_us;
    const std::int64_t since_us = graph->newest_utime_us() - start_us_;
    if (static_cast<double>(since_us) * 1e-6 < at_s_[next_]) return;
    ++next_;
    std::map<std::int64_t, NodeId> by_time;
    for (const auto& [id, node] : graph->nodes()) by_time[node.utime_us] = id;
    const NodeId to = by_time.rbegin()->second;
    const auto half = by_time.lower_bound(start_us_ + since_us / 2);
    if (half == by_time.end() || half->second == to) return;
    const NodeId from = half->second;
    const SE3 T_from_to =
        graph->nodes().at(from).T_map_base.inverse() * graph->nodes().at(to).T_map_base;
    Vector6d variance;
    variance << Eigen::Vector3d::Constant(0.05 * 0.05), Eigen::Vector3d::Constant(0.017 * 0.017);
    const auto before = places(*graph);
    const SE3 T_told =
        by_m_ > 0.0 ? SE3(T_from_to * from_xyz_rpy(by_m_, 0, 0, 0, 0, 0)) : SE3(SE3::Identity());
    graph->add_loop({from, to, T_told, variance.asDiagonal(), {}});
    injected_[{from, to}] = since_us;
    std::printf(
        "false closure put in at %.1f s: %s %ld - %s %ld, %.2f m beside where the graph "
        "has them; at first it moves nodes by up to %.3f m\n",
        1e-6 * static_cast<double>(since_us), kind(from), static_cast<long>(from.id), kind(to),
        static_cast<long>(to.id), local(T_told, T_from_to).head<3>().norm(), moved(before, *graph));
  }

  void say_switched_off(const PoseGraph& graph, const LoopState& off) {
    const auto it = injected_.find({off.from, off.to});
    const double now_s = 1e-6 * static_cast<double>(graph.newest_utime_us() - start_us_);
    if (it == injected_.end()) {
      std::printf("a closure of the detector's switched off: %s %ld - %s %ld: %s\n", kind(off.from),
                  static_cast<long>(off.from.id), kind(off.to), static_cast<long>(off.to.id),
                  off.reason.c_str());
      return;
    }
    std::printf("false closure switched off %.1f s later: %s\n",
                now_s - 1e-6 * static_cast<double>(it->second), off.reason.c_str());
    injected_.erase(it);
  }

  void say_remaining(const PoseGraph& graph) const {
    if (at_s_.empty()) return;
    for (const auto& [loop, since_us] : injected_)
      for (const GraphEdge& edge : graph.edges())
        if (edge.kind == EdgeKind::kLoop && edge.from == loop.first && edge.to == loop.second)
          std::printf("false closure of %.1f s still in the graph, weight %.3f\n",
                      1e-6 * static_cast<double>(since_us), edge.loop_weight);
    std::printf("false closures: %zu put in, %zu never switched off\n", next_, injected_.size());
  }

 private:
  static const char* kind(const NodeId& id) {
    return id.kind == NodeKind::kLidar ? "scan" : "keyframe";
  }
  static std::map<NodeId, SE3> places(const PoseGraph& graph) {
    std::map<NodeId, SE3> at;
    for (const auto& [id, node] : graph.nodes()) at[id] = node.T_map_base;
    return at;
  }
  static double moved(const std::map<NodeId, SE3>& before, const PoseGraph& graph) {
    double most_m = 0.0;
    for (const auto& [id, T] : before)
      most_m = std::max(most_m,
                        (graph.nodes().at(id).T_map_base.translation() - T.translation()).norm());
    return most_m;
  }

  std::vector<double> at_s_;
  double by_m_ = 0.0;
  std::size_t next_ = 0;
  std::int64_t start_us_ = 0;
  std::map<std::pair<NodeId, NodeId>, std::int64_t> injected_;  // and when, us since the first node
};

}  // namespace fusion_slam
