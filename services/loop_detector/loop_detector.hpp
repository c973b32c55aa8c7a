// Says when a sensor is at a place where one has been before, in stages that each leave their
// verdict: appearance and geometry (camera), lidar (branch-and-bound match of the scan with the
// candidate's submap), consistency (with the graph's uncertainty and with other loops). The LiDAR
// also searches by itself, in the window that the graph's uncertainty leaves open. Knows no bus.
// Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
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
  std::int64_t retired = 0;      // keyframes of places seen many times
  std::int64_t nothing_new = 0;  // views of such places that were not compared
};

// What a later process must know that is built up from the same nodes.
struct KnownPlacesNews {
  std::vector<NodeId> retired;  // keyframes that are no places any more
  std::vector<NodeId> known;    // places that have been seen many times
};

class LoopDetector {
 public:
  explicit LoopDetector(const RobotModel& robot, const LoopDetectorConfig& config = {});

  // Needed before keyframes can be compared; the first one stays.
  void set_camera(const CameraModel& camera);

  // Each returns the candidates whose fate is decided by now. A node whose id is not above the last
  // one's of its kind is ignored.
  std::vector<LoopCandidate> add(const LoopKeyframe& keyframe);
  std::vector<LoopCandidate> add(const LoopScan& scan);
  // The same of nodes that an earlier process has looked at: remembered, and nothing is searched.
  void remember(const LoopKeyframe& keyframe);
  void remember(const LoopScan& scan);
  void remember(const LoopMeasurement& loop) { graph_.add_loop(loop); }  // a loop it accepted
  // Before the nodes that it is about.
  void remember(const KnownPlacesNews& news);
  std::vector<LoopCandidate> finish();  // those that still wait for others are rejected

  void add_tile(const Tile& tile) { submaps_.add_tile(tile); }
  // Where the graph has a node.
  void moved(const NodeId& id, const SE3& T_map_base) { graph_.moved(id, T_map_base); }
  // The graph has switched a loop off.
  void switched_off(const NodeId& from, const NodeId& to);

  KnownPlacesNews take_news();  // since the last call

  // All that it knows but the features of keyframes, the points of scans and the tiles: for another
  // process of the same robot, which restores it before anything else and then remembers the
  // messages that are needed. Bytes: docs/formats.md. False: damaged, or of another version; then
  // it knows nothing.
  void write(NoteWriter* out) const;
  bool restore(NoteReader* in);
  // Numbers (seq) of the KEYFRAMEs and LIDAR_NODEs that such a process needs.
  std::set<std::int64_t> needed_keyframes() const;
  std::set<std::int64_t> needed_scans() const;

  const LoopCounts& counts() const { return counts_; }
  // Of what is kept, for who watches that it grows with the area.
  struct Sizes {
    std::size_t places = 0, keyframes = 0, nodes = 0, edges = 0, submaps = 0;
  };
  Sizes sizes() const;

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
  std::vector<std::int64_t> keep(const LoopKeyframe& keyframe);
  std::vector<std::int64_t> keep_features(const LoopKeyframe& keyframe);
  void complete(const LoopKeyframe& keyframe);
  void keep(const LoopScan& scan);
  void keep_points(const LoopScan& scan);
  bool due(const LoopScan& scan);
  std::vector<LoopCandidate> search(const LoopScan& scan, const Target& target);
  std::string rival_elsewhere(const LoopScan& scan, const Target& target, const SE2& T_submap_base);
  std::vector<std::int64_t> views_like(std::int64_t keyframe) const;
  void thin_out(std::int64_t keyframe);
  void retire(const NodeId& keyframe);
  bool says_nothing_new(std::int64_t place, std::int64_t keyframe) const;
  bool is_mere_link(const NodeId& scan) const;
  void forget_scan(const NodeId& scan);
  void forget_old_scans();
  std::vector<LoopCandidate> weigh(LoopCandidate candidate, int alike);
  std::vector<LoopCandidate> settle(std::vector<LoopCandidate> decided);

  RobotModel robot_;
  LoopDetectorConfig config_;
  std::optional<CameraModel> camera_;
  PlaceIndex places_;
  GraphKnowledge graph_;
  SubmapStore submaps_;
  Consistency consistency_;
  std::map<std::int64_t, LoopKeyframe> keyframes_;       // places, and those that will be
  std::map<std::int64_t, std::int64_t> keyframe_times_;  // of keyframes_: utime, id
  std::int64_t last_keyframe_ = 0;
  std::set<std::int64_t> known_places_;    // seen many times
  std::set<std::int64_t> retired_before_;  // by an earlier process
  std::set<std::int64_t> kept_before_;     // restored, the features not here yet
  std::deque<std::int64_t> links_;         // scans that may become mere links of their chain
  KnownPlacesNews news_;
  struct ScanPoints {
    std::int64_t seq = 0;
    Points points_base;
  };
  std::map<std::int64_t, ScanPoints> scans_;  // of the latest scans, for verification
  std::int64_t last_scan_ = 0;
  std::int64_t chain_begins_at_ = 0;    // the scan since which each knows the one before
  std::optional<SE3> T_odom_searched_;  // where the LiDAR searched last
  LoopCounts counts_;
};

}  // namespace fusion_slam
