// Says when a sensor is at a place where one has been before, in stages that each leave their
// verdict: appearance and geometry (camera), lidar (branch-and-bound match of the scan with the
// candidate's submap), consistency (with the graph's uncertainty and with other loops). The LiDAR
// also searches by itself, in the window that the graph's uncertainty leaves open. Knows no bus.
// Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/places/geometry_check.hpp"
#include "libs/places/place_index.hpp"
#include "libs/robot/robot_model.hpp"
#include "services/loop_detector/config.hpp"
#include "services/loop_detector/consistency.hpp"
#include "services/loop_detector/graph_knowledge.hpp"
#include "services/loop_detector/lidar_check.hpp"
#include "services/loop_detector/loop_types.hpp"
#include "services/loop_detector/submap_store.hpp"

namespace fusion_slam {

struct LoopCounts {
  std::int64_t keyframes = 0;
  std::int64_t scans = 0;
  std::int64_t lidar_searches = 0;
  std::int64_t candidates = 0;
  std::int64_t accepted = 0;
};

class LoopDetector {
 public:
  explicit LoopDetector(const RobotModel& robot, const LoopDetectorConfig& config = {});

  // Needed before keyframes can be compared; the first one stays.
  void set_camera(const CameraModel& camera);

  // Each returns the candidates whose fate is decided by now. A node whose id is not above the last
  // one's of its kind is ignored.
  std::vector<LoopCandidate> add(LoopKeyframe keyframe);
  std::vector<LoopCandidate> add(const LoopScan& scan);
  // The same of nodes that an earlier process has looked at: remembered, and nothing is searched.
  void remember(LoopKeyframe keyframe);
  void remember(const LoopScan& scan);
  void remember(const LoopMeasurement& loop) { graph_.add_loop(loop); }  // a loop it accepted
  std::vector<LoopCandidate> finish();  // those that still wait for others are rejected

  void add_tile(const Tile& tile) { submaps_.add_tile(tile); }
  // Where the graph has a node.
  void moved(const NodeId& id, const SE3& T_map_base) { graph_.moved(id, T_map_base); }
  // The graph has switched a loop off.
  void switched_off(const NodeId& from, const NodeId& to);

  const LoopCounts& counts() const { return counts_; }

 private:
  struct Target {  // a submap that may hold the place of a scan
    std::int64_t submap_id = 0;
    double distance_m = 0.0;
    double window_m = 0.0;
    double window_rad = 0.0;
    bool capped = false;  // the graph knows less than the largest window
    bool connected = true;
    SE3 T_submap_base = SE3::Identity();
  };

  std::vector<LoopCandidate> examine(const PlaceIndex::Place& place, const LoopKeyframe& keyframe);
  StageVerdict verify_by_lidar(const LoopKeyframe& older, const LoopKeyframe& newer, bool vague,
                               LoopCandidate* candidate, LidarOpinion* opinion);
  std::vector<Target> targets(const LoopScan& scan) const;
  void keep(const LoopScan& scan);
  bool due(const LoopScan& scan);
  std::vector<LoopCandidate> search(const LoopScan& scan, const Target& target);
  std::string rival_elsewhere(const LoopScan& scan, const Target& target, const SE2& T_submap_base);
  std::vector<LoopCandidate> weigh(LoopCandidate candidate, int alike);
  std::vector<LoopCandidate> settle(std::vector<LoopCandidate> decided);

  RobotModel robot_;
  LoopDetectorConfig config_;
  std::optional<CameraModel> camera_;
  PlaceIndex places_;
  GraphKnowledge graph_;
  SubmapStore submaps_;
  Consistency consistency_;
  std::map<std::int64_t, LoopKeyframe> keyframes_;
  std::map<std::int64_t, Points> scans_;  // points of the latest scans, for verification
  std::int64_t last_scan_ = 0;
  std::int64_t chain_begins_at_ = 0;    // the scan since which each knows the one before
  std::optional<SE3> T_odom_searched_;  // where the LiDAR searched last
  LoopCounts counts_;
};

}  // namespace fusion_slam
