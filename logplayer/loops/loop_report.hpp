// What became of each idea of a loop in a session, for people: fed with the session's messages,
// says which were accepted, why the others were not, what the graph switched off again, and, where
// the log has ground truth, which of the accepted were wrong and how many places were missed.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/loop_candidate_t.hpp"
#include "libs/geometry/timed_poses.hpp"
#include "libs/graph/node_id.hpp"

namespace fusion_slam {

struct LoopReportOptions {
  bool all = false;  // each candidate on a line, not only the accepted
  // A closure is wrong when it is this far from the truth.
  double wrong_m = 0.3;
  double wrong_rad = 0.1;
  // A place is seen again when the robot is this near to where it was so long before.
  double again_m = 1.0;
  double again_rad = 0.5;
  std::int64_t again_us = 30'000'000;
  double recall_m = 2.0;  // travelled: a revisit counts as found when a closure is this near
};

struct ClosureTruth {
  std::size_t judged = 0;  // closures whose both nodes have a true pose
  std::size_t wrong = 0;
  double median_error_m = 0.0;
  std::size_t revisits = 0;  // metres of the way where the robot was before
  std::size_t found = 0;     // of them, with a closure near
};

class LoopReport {
 public:
  void on_node(const NodeId& id, std::int64_t utime_us) { utime_of_[id] = utime_us; }
  void on_candidate(const loop_candidate_t& message) { candidates_.push_back(message); }
  void on_constraint(const constraint_t& message);
  void on_graph(const graph_t& message);
  void on_truth(std::int64_t utime_us, const SE3& T_world_base) { truth_[utime_us] = T_world_base; }
  void on_robot(const SE3& T_base_reference) { T_base_reference_ = T_base_reference; }

  std::string text(const LoopReportOptions& options) const;
  // Nothing without ground truth.
  std::optional<ClosureTruth> judge(const LoopReportOptions& options) const;
  // The accepted closures as relations (Kuemmerle et al. 2009), one a line: "t1 t2 x y z roll pitch
  // yaw" in s, m and rad, of the frame that trajectories are written in. `eval relations` and
  // tests/bench/loops/closure_score read them. Closures whose nodes never came are left out.
  std::string as_relations() const;

 private:
  struct Closure {
    NodeId from;
    NodeId to;
    SE3 T_from_to = SE3::Identity();
    std::string source;
  };
  std::optional<SE3> true_pose(const NodeId& id) const;
  std::optional<Vector6d> true_error(const Closure& closure) const;
  std::string line(const loop_candidate_t& candidate) const;
  std::string wrong_lines(const LoopReportOptions& options) const;

  std::map<NodeId, std::int64_t> utime_of_;
  std::vector<loop_candidate_t> candidates_;
  std::vector<Closure> closures_;
  std::vector<loop_state_t> switched_off_;
  std::int64_t graph_loops_ = 0;
  TimedPoses truth_;
  SE3 T_base_reference_ = SE3::Identity();
};

}  // namespace fusion_slam
