// What the loop detector knows of the pose graph: where GRAPH says the nodes are, and, from the
// edges that both trackers measured, how well they are known relative to each other.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "libs/graph/edge_noise.hpp"
#include "libs/graph/uncertainty.hpp"
#include "services/loop_detector/loop_types.hpp"

namespace fusion_slam {

class GraphKnowledge {
 public:
  explicit GraphKnowledge(bool planar = true, EdgeNoiseConfig noise = {})
      : planar_(planar), noise_(noise) {}

  void add(const LoopKeyframe& keyframe);
  void add(const LoopScan& scan);
  void moved(const NodeId& id, const SE3& T_map_base);
  void add_loop(const LoopMeasurement& loop);
  void remove_loop(const NodeId& from, const NodeId& to);
  // The node is of no use any more; how well others are known by way of it stays.
  void retire(const NodeId& id);

  // As the graph has it; where it has not (yet), odometry from the newest node of the kind that it
  // has. Nothing: never heard of.
  std::optional<SE3> T_map_base(const NodeId& id) const;

  // The scan nearest to a time, at most max_gap_us away.
  std::optional<NodeId> scan_near(std::int64_t utime_us, std::int64_t max_gap_us) const;

  // All scans so near, the earliest first.
  std::vector<NodeId> scans_near(std::int64_t utime_us, std::int64_t max_gap_us) const;
  std::optional<std::int64_t> utime_us(const NodeId& id) const;  // nothing: unknown, or retired

  struct Relative {
    SE3 T_from_to = SE3::Identity();  // by the graph's poses
    Matrix6d covariance = Matrix6d::Zero();
    bool connected = true;  // false: no edges lead there, the covariance is a guess, wide
  };
  GraphUncertainty::Paths paths_from(const NodeId& id) const { return edges_.from(id); }
  // From the node that `paths` start at; they are searched as far as it takes.
  std::optional<Relative> relative(GraphUncertainty::Paths* paths, const NodeId& from,
                                   const NodeId& to) const;
  std::optional<Relative> relative(const NodeId& from, const NodeId& to) const;

  // All of it in a journal note, and back. False: damaged.
  void write(NoteWriter* out) const;
  bool read(NoteReader* in);

  bool planar() const { return planar_; }
  std::size_t n_nodes() const { return nodes_.size(); }
  std::size_t n_edges() const { return edges_.n_edges(); }

 private:
  struct Node {
    std::int64_t utime_us = 0;
    SE3 T_odom_base = SE3::Identity();
  };
  void remember(const NodeId& id, std::int64_t utime_us, const SE3& T_odom_base);
  void tie(const NodeId& keyframe);
  bool is_retired(const NodeId& id) const;

  bool planar_;
  EdgeNoiseConfig noise_;
  GraphUncertainty edges_;
  std::map<NodeId, Node> nodes_;
  std::map<NodeKind, std::int64_t> newest_;  // ids
  std::map<NodeId, SE3> T_map_base_;
  std::map<std::int64_t, NodeId> scans_by_time_;
  std::map<NodeId, bool> tied_;  // keyframes with an edge to a scan
};

}  // namespace fusion_slam
