// 2D LiDAR SLAM's front end after Hess et al. 2016 ("Real-time loop closure in 2D LIDAR SLAM"),
// without the loop closure, which is the pose graph's. Knows no bus and no clock: what it says
// depends on its calls only. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"
#include "services/lidar_mapper/config.hpp"
#include "services/lidar_mapper/match_scan.hpp"
#include "services/lidar_mapper/motion_predictor.hpp"
#include "services/lidar_mapper/pose_filter.hpp"
#include "services/lidar_mapper/scan_clock.hpp"
#include "services/lidar_mapper/submap.hpp"

namespace fusion_slam {

struct LidarNode {
  std::int64_t id = 0;  // 1, 2, 3 ...
  std::int64_t utime_us = 0;
  SE2 T_odom_base;
  std::int64_t previous_id = 0;  // 0: none
  SE2 T_previous_base;
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  // of T_previous_base, (x, y, yaw) in base axes
  std::vector<ActiveSubmaps::Membership> submaps;
  Points points_base;
};

struct LidarPose {
  std::int64_t utime_us = 0;
  SE2 T_odom_base;
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  // in the local map, (x, y, yaw) in base axes
  MatchState state = MatchState::kOk;
  std::string reason;
  std::int64_t reference_id = 0;  // node that this pose hangs on
  SE2 T_reference_base;
  std::int64_t fix_utime_us = 0;  // last scan that was not kLost
  int n_matched = 0;
};

// What one scan led to. No pose: the scan was dropped (repeated, or no node yet and too few
// returns).
struct MapperOutput {
  std::optional<LidarPose> pose;
  std::optional<LidarNode> node;
  std::vector<Tile> tiles;  // of submaps, grid probability
};

struct MapperCounts {
  std::int64_t scans = 0;
  std::int64_t duplicates = 0;       // same stamp, same ranges
  std::int64_t doubtful_stamps = 0;  // repeated, backwards, or too close
  std::int64_t unusable = 0;         // too few returns
  std::int64_t weak = 0;
  std::int64_t lost = 0;
  std::int64_t nodes = 0;
  std::int64_t restarts = 0;  // of the map after being lost
  std::int64_t segments = 0;  // begun after a silence: nothing ties them to the one before
};

class LidarMapper {
 public:
  explicit LidarMapper(const RobotModel& robot, const LidarMapperConfig& config = {});

  // Poses in frames of their own; times in any order up to those of the scans.
  void add_odometry(std::int64_t utime_us, const SE2& T_odom_base);
  void add_visual_pose(std::int64_t utime_us, const SE2& T_odom_base, bool reliable);

  MapperOutput add_scan(const LaserScan& scan);

  // Forgets the map: the next scan begins a new one, where this one's odom has the robot. Ids count
  // on, and the first node has none before it.
  void reset();

  // Goes on where an earlier process ended, before the first scan: its last nodes, oldest first, at
  // least nodes_to_resume() of them where there are as many. The active submaps are built again
  // from their scans; the next scan is looked for around the last node, as after a gap in the
  // scans. Ids go on, from first_id on if that is larger (after a power cut, when nobody knows
  // which ids were given last). Returns the active submaps' tiles.
  std::vector<Tile> resume(const std::vector<LidarNode>& nodes, std::int64_t first_id = 1);
  static int nodes_to_resume(const LidarMapperConfig& config = {}) {
    return 2 * config.nodes_per_half_submap;
  }

  // What add_scan still held back: the changed tiles of the active submaps. Mapping may go on
  // afterwards.
  std::vector<Tile> finish();

  const MapperCounts& counts() const { return counts_; }

 private:
  bool is_duplicate(const LaserScan& scan) const;
  void begin_segment(std::vector<Tile>& tiles);
  ScanMatch place(const ScanPoints& points, bool usable, const Prediction& prediction);
  void accept(const ScanMatch& match, const Prediction& prediction,
              const ScanClock::Interval& interval);
  bool deserves_node() const;
  LidarNode make_node(const ScanPoints& points, std::int64_t utime_us, std::vector<Tile>& tiles);
  LidarPose make_pose_estimate(const ScanMatch& match, double late_s) const;

  const RobotModel robot_;
  const LidarMapperConfig config_;
  ScanClock clock_;
  MotionPredictor predictor_;
  ActiveSubmaps submaps_;
  std::unique_ptr<SearchPyramid> pyramid_;  // of the oldest submap; made anew after it changed
  LaserScan last_scan_;
  SE2 T_odom_base_;  // of the last scan
  PoseFilter filter_;
  std::int64_t last_fix_us_ = 0;
  int lost_in_a_row_ = 0;
  bool blind_ = false;         // the next scan that can be used begins a segment
  bool resumed_ = false;       // and no scan came since
  std::int64_t node_id_ = 0;   // last node
  std::int64_t first_id_ = 1;  // none is smaller from now on
  bool chain_begins_ = true;   // the next node has none before it
  SE2 T_odom_node_;
  int nodes_since_publication_ = 0;
  MapperCounts counts_;
};

}  // namespace fusion_slam
