// Stage 4: does a loop agree with what the graph knows, and do enough loops agree with each other?
// A loop beyond what the graph's uncertainty allows is no loop, however alike the places look. One
// inside it may still be wrong: it waits until others, from other places along the way, tell the
// same story (pairwise consistency: Mangelson et al. 2018; Olson 2009).
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "services/loop_detector/config.hpp"
#include "services/loop_detector/graph_knowledge.hpp"

namespace fusion_slam {

class Consistency {
 public:
  explicit Consistency(const ConsistencyConfig& config) : config_(config) {}

  struct Gate {
    double squared_distance = 0.0;  // in units of both covariances
    double threshold = 0.0;
    bool inside = false;
    double sigma_m = 0.0;  // the graph's, worst direction in the plane
    std::string reason;
  };
  Gate gate(const GraphKnowledge& graph, const LoopMeasurement& loop) const;

  // Judges a candidate that passed the gate; `alike` loops, itself counted, must agree. Returns all
  // whose fate is now decided, this one or earlier ones among them, each with its last stage
  // filled in. Those not returned wait.
  std::vector<LoopCandidate> judge(const GraphKnowledge& graph, LoopCandidate candidate, int alike);
  // Candidates that have waited too long at that time; with `all`, all that wait.
  std::vector<LoopCandidate> expired(std::int64_t utime_us, bool all);
  // A candidate that waits is about this node; or one that vouches for others.
  bool waits_for(const NodeId& id) const;
  bool mentions(const NodeId& id) const;
  // A loop turned out wrong: it vouches for no other any more.
  void forget(const NodeId& from, const NodeId& to);

 private:
  struct Entry {
    LoopCandidate candidate;
    int alike = 1;
    bool accepted = false;
  };
  static bool is_about(const Entry& entry, const NodeId& id);
  bool agree(const GraphKnowledge& graph, const LoopCandidate& a, const LoopCandidate& b) const;
  bool apart(const GraphKnowledge& graph, const LoopCandidate& a, const LoopCandidate& b) const;

  ConsistencyConfig config_;
  std::deque<Entry> entries_;  // waiting and the latest accepted, oldest first
};

// Squared Mahalanobis distance of an error between base poses: x, y, yaw only when planar.
double squared_distance(const Vector6d& error, const Matrix6d& covariance, bool planar);

}  // namespace fusion_slam
