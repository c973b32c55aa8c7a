// Where is a robot in a map that was saved? Starts from nothing: a search of the whole map by the
// LiDAR and the views that the camera knows again must agree (LiDAR-only: stricter, see config).
// Then it follows scan by scan, and says so when scans contradict the map. The map never changes.
// Knows no bus. Not thread-safe. Deterministic: same inputs in the same order, same bits.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libs/graph/node_id.hpp"
#include "libs/localization/lidar_search.hpp"
#include "libs/localization/localization_map.hpp"
#include "libs/localization/odometry_track.hpp"
#include "libs/localization/scan_memory.hpp"
#include "libs/localization/visual_search.hpp"

namespace fusion_slam {

enum class LocalizationState : std::int8_t { kUnknown = 0, kCandidate = 1, kLocalized = 2 };

struct LocalScan {  // LIDAR_NODE
  std::int64_t id = 0;
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();  // the LiDAR's odom
  bool starts_anew = false;           // not continuous with the scan before
  Points points_base;
};

struct LocalView {  // KEYFRAME
  std::int64_t id = 0;
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();  // the camera's odom
  bool starts_anew = false;
  FeatureSet features;  // ideal pixels
};

// A node of the running session, placed in the map.
struct PlacedNode {
  std::int64_t utime_us = 0;
  SE3 T_map_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of it, base axes
};

// A measurement between a node of the session and the map, of which both sensors (or the only one)
// are sure: what joins two sessions.
struct MapFix {
  NodeId node;  // of the session
  PlacedNode where;
  std::int64_t map_keyframe = 0;  // known again by the camera; 0: by the LiDAR's grid
};

class Localizer {
 public:
  // The map must outlive this object.
  explicit Localizer(const LocalizationMap& map);

  // What the running robot has, when that is less than the robot that made the map had: a sensor
  // that never comes is not waited for, and the one that does follows its stricter rules.
  void set_sensors(bool lidar, bool camera);

  void add_lidar_pose(std::int64_t utime_us, const SE3& T_odom_base);
  void lidar_lost();
  void add_scan(const LocalScan& scan);
  void add_view(const LocalView& view);

  // A person says where the robot is, roughly (1 m, 30 degrees). False, with the reason, when what
  // the LiDAR sees does not fit there; nothing changes then.
  bool hint(const SE2& T_map_base, std::string* why);
  void start_anew() { forget("asked to start anew"); }

  LocalizationState state() const { return state_; }
  // For people: what was found, or why nothing was.
  const std::string& reason() const { return reason_; }
  // Where the robot may be (kCandidate) or is (kLocalized), at the newest node.
  const std::optional<PlacedNode>& here() const { return here_; }
  double score() const { return score_; }  // share of the LiDAR's points that agree with the map
  std::int64_t searches() const { return searches_; }
  std::int64_t localized_utime_us() const {
    return localized_us_;
  }  // of the latest fix from nothing

  // Nodes placed, or placed better, since the last call; in order.
  std::vector<std::pair<NodeId, PlacedNode>> take_placed();
  // All that are placed now.
  const std::map<NodeId, PlacedNode>& placed() const { return placed_; }
  std::vector<MapFix> take_fixes();

 private:
  struct Node {
    std::int64_t utime_us = 0;
    SE3 T_odom_base = SE3::Identity();  // of the odom that the session is placed by
  };
  struct Answer {  // one sensor's idea of where the odom frame lies in the map
    std::int64_t utime_us = 0;
    SE3 T_map_odom = SE3::Identity();
    SE3 T_odom_base = SE3::Identity();  // where it was asked
    Matrix6d covariance = Matrix6d::Identity();
    double agreement = 0.0;
    double score = 0.0;
    int n_inliers = 0;
    std::int64_t map_keyframe = 0;
    bool unique = false;  // no other place of the map is about as good
  };

  bool by_lidar() const { return has_lidar_ && map_.grid() != nullptr; }
  bool by_camera() const { return has_camera_ && !map_.views().empty(); }
  bool due_for_search(const LocalScan& scan) const;
  void search_by_lidar(const LocalScan& scan);
  void resolve_views();
  void search_by_camera(const LocalView& view, const SE3& T_odom_base);
  void weigh(const Node& now);
  bool both_agree(const Answer& view, const Node& now);
  bool lidar_alone(const Node& now);
  bool camera_alone(const Node& now);
  bool same_place(const Answer& a, const Answer& b, const SE3& T_odom_base) const;
  void localize(const Answer& answer, const Node& now, const std::string& how);
  void track_by_lidar(const LocalScan& scan);
  void track_by_camera(const LocalView& view);
  void place(const NodeId& id, const Node& node, const Matrix6d& covariance);
  void forget(const std::string& why);
  void forget_old(std::int64_t utime_us);
  void candidate(const Answer& answer, const Node& now, const std::string& why);

  const LocalizationMap& map_;
  LocalizerConfig config_;
  bool has_lidar_ = true;
  bool has_camera_ = true;
  LocalizationState state_ = LocalizationState::kUnknown;
  std::string reason_ = "nothing seen yet";
  std::optional<PlacedNode> here_;
  double score_ = 0.0;
  std::int64_t searches_ = 0;
  std::int64_t localized_us_ = 0;

  OdometryTrack lidar_track_;
  ScanMemory memory_;
  int vain_searches_ = 0;             // of the whole map, since the track began
  std::optional<SE3> searched_at_;    // T_odom_base of the last full-map search
  std::deque<LocalView> views_;       // that wait for the LiDAR's odometry
  std::deque<Answer> lidar_answers_;  // oldest first
  std::deque<Answer> camera_answers_;
  SE3 T_map_odom_ = SE3::Identity();  // once localised
  Matrix6d covariance_ = Matrix6d::Identity();
  int contradictions_ = 0;        // scans in a row
  std::map<NodeId, Node> nodes_;  // of the track that runs
  std::map<NodeId, PlacedNode> placed_;
  std::map<NodeId, PlacedNode> news_;
  std::vector<MapFix> fixes_;
};

}  // namespace fusion_slam
