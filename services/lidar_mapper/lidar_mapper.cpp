#include "services/lidar_mapper/lidar_mapper.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace fusion_slam {
namespace {

void append(std::vector<Tile>& all, std::vector<Tile> more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

LidarMapper::LidarMapper(const RobotModel& robot, const LidarMapperConfig& config)
    : robot_(robot),
      config_(config),
      clock_(robot.lidar.rate_hz),
      predictor_(config),
      submaps_(robot.map_resolution_m, config) {}

void LidarMapper::add_odometry(std::int64_t utime_us, const SE2& T_odom_base) {
  predictor_.add_odometry(utime_us, T_odom_base);
}

void LidarMapper::add_visual_pose(std::int64_t utime_us, const SE2& T_odom_base, bool reliable) {
  if (reliable)
    predictor_.add_visual(utime_us, T_odom_base);
  else
    predictor_.visual_lost();
}

MapperOutput LidarMapper::add_scan(const LaserScan& scan) {
  MapperOutput out;
  ++counts_.scans;
  if (is_duplicate(scan)) {
    ++counts_.duplicates;
    return out;
  }
  const ScanClock::Interval interval = clock_.advance(scan.utime_us);
  const Prediction prediction =
      predictor_.predict(last_scan_.utime_us, scan.utime_us, interval, robot_.map_resolution_m);
  ScanPoints points =
      read_scan(scan, robot_, prediction.twist, config_.max_range_cells * robot_.map_resolution_m);
  const bool usable = points.hits_base.size() >= static_cast<std::size_t>(config_.min_points);
  counts_.unusable += usable ? 0 : 1;
  counts_.doubtful_stamps += interval.trusted || node_id_ == 0 ? 0 : 1;
  last_scan_ = scan;
  if (!usable && node_id_ == 0) return out;
  blind_ = blind_ || (prediction.blind && node_id_ != 0 && !resumed_);
  resumed_ = false;
  const bool new_segment = blind_ && usable;
  if (new_segment) begin_segment(out.tiles);

  ScanMatch match = place(points, usable, prediction);
  if (new_segment) {
    match.state = MatchState::kLost;
    match.reason = "after a silence of all sensors: a new segment begins";
  }
  accept(match, prediction, interval);
  if (usable && lost_in_a_row_ >= config_.lost_scans_to_restart) {
    append(out.tiles, submaps_.finish_all());
    ++counts_.restarts;
  }
  const bool lost = match.state == MatchState::kLost;
  if (usable && (submaps_.empty() || (!lost && deserves_node()))) {
    straighten(scan, robot_, match.twist, points);
    const auto measured_us =
        scan.utime_us - static_cast<std::int64_t>(std::llround(interval.late_s * 1e6));
    out.node = make_node(points, measured_us, out.tiles);
  }
  out.pose = make_pose_estimate(match, interval.late_s);
  return out;
}

bool LidarMapper::is_duplicate(const LaserScan& scan) const {
  if (scan.utime_us != last_scan_.utime_us) return false;
  const auto& a = scan.ranges_m;
  const auto& b = last_scan_.ranges_m;
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

// After a silence in which the robot may have gone further than any search reaches, a match would
// be a guess that the graph takes for a measurement. The scan begins a map and a chain of its own,
// which wheels, the camera or closures tie to the old one.
void LidarMapper::begin_segment(std::vector<Tile>& tiles) {
  append(tiles, submaps_.finish_all());
  pyramid_.reset();
  predictor_.forget_velocity();
  chain_begins_ = true;
  blind_ = false;
  lost_in_a_row_ = 0;
  ++counts_.segments;
}

ScanMatch LidarMapper::place(const ScanPoints& points, bool usable, const Prediction& prediction) {
  if (node_id_ == 0) {
    ScanMatch first;
    first.T_odom_base = T_odom_base_;
    first.state = MatchState::kOk;
    return first;
  }
  filter_.predict(prediction.motion, prediction.covariance());
  const SE2 T_odom_predicted = T_odom_base_ * prediction.motion;
  if (!usable) return dead_reckon(T_odom_predicted, prediction, "too few beams returned");
  if (submaps_.empty()) {  // after reset()
    ScanMatch first;
    first.T_odom_base = T_odom_predicted;
    first.state = MatchState::kOk;
    return first;
  }
  if (!pyramid_) pyramid_ = std::make_unique<SearchPyramid>(submaps_.oldest().raster());
  return match_scan(submaps_.oldest(), *pyramid_, points, T_odom_predicted, prediction,
                    filter_.covariance(), robot_, config_);
}

void LidarMapper::accept(const ScanMatch& match, const Prediction& prediction,
                         const ScanClock::Interval& interval) {
  const bool lost = match.state == MatchState::kLost;
  const Eigen::Matrix3d predicted = filter_.covariance();
  if (!lost) {
    filter_.update(match.information);
    last_fix_us_ = last_scan_.utime_us;
  } else {  // whatever has gone wrong, the prediction may be part of it
    filter_.predict({},
                    Eigen::Vector3d(prediction.window_m, prediction.window_m, prediction.window_rad)
                        .array()
                        .square()
                        .matrix()
                        .asDiagonal());
  }
  if (match.state == MatchState::kOk && !submaps_.empty()) {
    const SE2 error = (T_odom_base_ * prediction.motion).inverse() * match.T_odom_base;
    // Only what the match saw better than the prediction knew.
    const Eigen::Vector3d before = predicted.diagonal();
    const Eigen::Vector3d gain = before - filter_.covariance().diagonal();
    const Eigen::Vector3d explained =
        (gain.array() > 0.5 * before.array()).select(gain, Eigen::Vector3d::Zero());
    predictor_.learn(
        prediction.source,
        {explained.x() > 0.0 ? error.x : 0.0, explained.y() > 0.0 ? error.y : 0.0, error.yaw},
        explained);
  }
  T_odom_base_ = match.T_odom_base;
  lost_in_a_row_ = lost ? lost_in_a_row_ + 1 : 0;
  counts_.lost += lost ? 1 : 0;
  counts_.weak += match.state == MatchState::kWeak ? 1 : 0;
  if (robot_.lidar.beam_period_s > 0.0 && !lost)
    predictor_.add_scan_pose(interval.dt_s, T_odom_base_, match.twist);
  else
    predictor_.add_scan_pose(interval.dt_s, T_odom_base_);
  // A guessed velocity is good for a moment; then the robot is better taken to stand.
  if (lost_in_a_row_ > 2 && prediction.source == PredictionSource::kConstantVelocity)
    predictor_.forget_velocity();
}

bool LidarMapper::deserves_node() const {
  const SE2 moved = T_odom_node_.inverse() * T_odom_base_;
  return std::hypot(moved.x, moved.y) >= config_.node_distance_m ||
         std::abs(moved.yaw) >= config_.node_angle_rad;
}

LidarNode LidarMapper::make_node(const ScanPoints& points, std::int64_t utime_us,
                                 std::vector<Tile>& tiles) {
  const bool new_map = submaps_.empty();
  LidarNode node;
  node.id = std::max(node_id_ + 1, first_id_);
  node.utime_us = utime_us;
  node.T_odom_base = T_odom_base_;
  node.previous_id = chain_begins_ ? 0 : node_id_;
  if (!chain_begins_) {
    node.T_previous_base = T_odom_node_.inverse() * T_odom_base_;
    node.covariance = filter_.since_node(node.T_previous_base);
  }
  append(tiles, submaps_.insert(node.id, points, T_odom_base_, utime_us));
  pyramid_.reset();
  if (++nodes_since_publication_ >= config_.nodes_per_publication) {
    append(tiles, submaps_.take_changed_tiles());
    nodes_since_publication_ = 0;
  }
  node.submaps = submaps_.inserted_into();
  node.points_base = points.hits_base;
  node_id_ = node.id;
  chain_begins_ = false;
  T_odom_node_ = T_odom_base_;
  if (new_map) {
    lost_in_a_row_ = 0;
    filter_.reset();
  }
  filter_.clone();
  ++counts_.nodes;
  return node;
}

// The pose at the scan's stamp. The scan was measured `late_s` before: the robot moved on.
LidarPose LidarMapper::make_pose_estimate(const ScanMatch& match, double late_s) const {
  LidarPose pose;
  pose.utime_us = last_scan_.utime_us;
  pose.T_odom_base =
      late_s == 0.0 ? T_odom_base_ : T_odom_base_ * predictor_.velocity().motion(late_s);
  pose.covariance = filter_.covariance();
  pose.state = match.state;
  pose.reason = match.reason;
  pose.reference_id = node_id_;
  pose.T_reference_base = T_odom_node_.inverse() * pose.T_odom_base;
  pose.fix_utime_us = last_fix_us_;
  pose.n_matched = match.overlap.n_matched;
  return pose;
}

void LidarMapper::reset() {
  submaps_ = ActiveSubmaps(robot_.map_resolution_m, config_);
  pyramid_.reset();
  filter_.reset();
  chain_begins_ = true;
  blind_ = false;
  lost_in_a_row_ = 0;
  nodes_since_publication_ = 0;
}

std::vector<Tile> LidarMapper::resume(const std::vector<LidarNode>& nodes, std::int64_t first_id) {
  if (node_id_ != 0) return {};
  first_id_ = first_id;
  if (nodes.empty()) return {};
  const LidarNode& last = nodes.back();
  for (const ActiveSubmaps::Membership& active : last.submaps) {
    Submap submap(active.submap_id, last.T_odom_base * active.T_submap_base.inverse(),
                  robot_.map_resolution_m, config_);
    for (const LidarNode& node : nodes)
      for (const ActiveSubmaps::Membership& member : node.submaps)
        if (member.submap_id == active.submap_id)
          submap.insert(points_again(node.points_base, robot_),
                        submap.T_odom_submap() * member.T_submap_base, node.utime_us);
    submaps_.restore(std::move(submap));
  }
  std::vector<Tile> tiles = submaps_.finish_full();
  append(tiles, submaps_.take_changed_tiles());
  node_id_ = last.id;
  chain_begins_ = false;
  T_odom_node_ = T_odom_base_ = last.T_odom_base;
  last_fix_us_ = last_scan_.utime_us = last.utime_us;
  clock_.advance(last.utime_us);
  resumed_ = true;
  filter_.clone();
  return tiles;
}

std::vector<Tile> LidarMapper::finish() {
  nodes_since_publication_ = 0;
  return submaps_.take_changed_tiles();
}

}  // namespace fusion_slam
