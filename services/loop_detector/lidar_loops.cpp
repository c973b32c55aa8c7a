// The LiDAR's part in loop detection: verification of what the camera found, and its own search.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "services/loop_detector/loop_detector.hpp"

namespace fusion_slam {
namespace {

double worst_sigma_m(const Matrix6d& covariance) {
  const Eigen::Matrix2d plane = covariance.topLeftCorner<2, 2>();
  return std::sqrt(std::max(
      0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(plane).eigenvalues().maxCoeff()));
}

Eigen::Matrix3d planar_part(const Matrix6d& covariance) {
  const int index[3] = {0, 1, 5};
  Eigen::Matrix3d plane;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) plane(i, j) = covariance(index[i], index[j]);
  return plane;
}

// z, roll and pitch are not the scan's business: the pose graph pins or frees them.
Matrix6d full_covariance(const Eigen::Matrix3d& planar, const LidarCheckConfig& config,
                         bool planar_robot) {
  Matrix6d full = Matrix6d::Zero();
  const int index[3] = {0, 1, 5};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) full(index[i], index[j]) = planar(i, j);
  const double z = planar_robot ? config.floor_m : 1.0;
  const double tilt = planar_robot ? config.floor_rad : 0.5;
  full(2, 2) = z * z;
  full(3, 3) = full(4, 4) = tilt * tilt;
  return full;
}

// The camera's answer where a scan has told where in the place it was: its pose with what both
// know, so that its features lie right; its covariance as before, for the scan is an edge of its
// own and may not count twice.
void draw_to(const SE3& T_by_scan, const Matrix6d& by_scan, LoopMeasurement* visual) {
  const Matrix6d both = visual->covariance + by_scan;
  const Vector6d step = local(visual->T_from_to, T_by_scan);
  visual->T_from_to = retract(visual->T_from_to, visual->covariance * both.ldlt().solve(step));
}

}  // namespace

// The scan of the newer keyframe's time in the submap of the older one's: it must fit, and at the
// place where the camera says.
StageVerdict LoopDetector::verify_by_lidar(const LoopKeyframe& older, const LoopKeyframe& newer,
                                           bool vague, LoopCandidate* candidate,
                                           LidarOpinion* opinion) {
  *opinion = LidarOpinion::kNothing;
  const LidarCheckConfig& config = config_.lidar;
  StageVerdict verdict{"lidar", 0.0, config.min_agreement, false, ""};
  const auto scan_then = graph_.scan_near(older.utime_us, config_.scan_gap_us);
  const auto scan_now = graph_.scan_near(newer.utime_us, config_.scan_gap_us);
  const auto points = scan_now ? scans_.find(scan_now->id) : scans_.end();
  if (!scan_then || points == scans_.end()) {
    verdict.reason = robot_.has_lidar ? "no scan of that time" : "the robot has no LiDAR";
    return verdict;
  }
  const SE3 T_then_older = graph_.T_map_base(*scan_then)->inverse() *
                           *graph_.T_map_base({NodeKind::kKeyframe, older.id});
  const SE3 T_newer_now =
      graph_.T_map_base({NodeKind::kKeyframe, newer.id})->inverse() * *graph_.T_map_base(*scan_now);
  const LoopMeasurement& visual = candidate->measurements.front();
  const SE3 T_then_now = T_then_older * visual.T_from_to * T_newer_now;

  for (const LoopScan::Membership& in : submaps_.submaps_of(scan_then->id)) {
    const UnpackedSubmap* submap = submaps_.unpacked(in.submap_id);
    if (submap == nullptr) continue;
    const SE3 T_submap_now = in.T_submap_base * T_then_now;
    const SearchWindow window{config_.verify_window_m, config_.verify_window_rad, 0.02};
    const LidarCheck check =
        check_scan(*submap, points->second.points_base, to_se2(T_submap_now), window, config);
    verdict.score = check.score;
    verdict.reason = check.reason;
    *opinion = check.opinion;
    if (check.opinion != LidarOpinion::kFits) return verdict;

    const SE2 error = to_se2(T_submap_now).inverse() * check.T_submap_base;
    Eigen::Matrix3d by_scan = check.covariance;
    by_scan.diagonal() +=
        Eigen::Vector3d(std::pow(config_.tie_sigma_m, 2), std::pow(config_.tie_sigma_m, 2),
                        std::pow(config_.tie_sigma_rad, 2));
    const Eigen::Matrix3d both =
        by_scan + planar_part(chained_covariance(visual.covariance, T_newer_now, Matrix6d::Zero()));
    const Eigen::Vector3d e(error.x, error.y, error.yaw);
    const double apart = e.dot(both.ldlt().solve(e));
    char text[160];
    std::snprintf(text, sizeof text, "%s; %.3f m and %.2f degrees from the camera's answer",
                  check.reason.c_str(), e.head<2>().norm(), std::abs(e.z()) * 180.0 / M_PI);
    verdict.reason = text;
    if (apart > config_.consistency.gate_3d) {
      *opinion = LidarOpinion::kNowhere;
      verdict.reason += ": they disagree";
      return verdict;
    }
    verdict.passed = true;
    if (vague) {
      const SE3 T_by_scan =
          T_then_older.inverse() *
          SE3(in.T_submap_base.inverse() * to_se3(check.T_submap_base) * T_newer_now.inverse());
      const Matrix6d covariance = chained_covariance(full_covariance(by_scan, config, false),
                                                     T_newer_now.inverse(), Matrix6d::Zero());
      draw_to(T_by_scan, covariance, &candidate->measurements.front());
    }
    candidate->measurements.push_back({{NodeKind::kLidar, in.submap_id},
                                       *scan_now,
                                       to_se3(check.T_submap_base),
                                       full_covariance(check.covariance, config, robot_.planar),
                                       {},
                                       "lidar loop"});
    // What stage 4 weighs is the one that knows.
    if (vague) std::swap(candidate->measurements.front(), candidate->measurements.back());
    return verdict;
  }
  verdict.reason = "no submap of that place came";
  return verdict;
}

bool LoopDetector::due(const LoopScan& scan) {
  if (T_odom_searched_) {
    const Vector6d step = local(*T_odom_searched_, scan.T_odom_base);
    if (step.head<3>().norm() < config_.search.every_m &&
        step.tail<3>().norm() < config_.search.every_rad)
      return false;
  }
  T_odom_searched_ = scan.T_odom_base;
  return true;
}

// Submaps that were left a while ago and that the graph's uncertainty lets the robot be in, the
// nearest first.
std::vector<LoopDetector::Target> LoopDetector::targets(const LoopScan& scan) const {
  const LidarSearchConfig& config = config_.search;
  const NodeId node{NodeKind::kLidar, scan.id};
  std::vector<Target> found;
  std::optional<GraphUncertainty::Paths> paths;
  for (const auto& [id, submap] : submaps_.all()) {
    if (submap.tiles.empty() || submap.members.empty()) continue;
    // The mapper's own business, unless its chain broke since.
    const bool same_chain = id >= chain_begins_at_;
    if (same_chain && scan.id - submap.members.back().node_id < config.min_node_gap) continue;
    const NodeId anchor{NodeKind::kLidar, id};
    const auto T_map_anchor = graph_.T_map_base(anchor);
    const auto T_map_node = graph_.T_map_base(node);
    if (!T_map_anchor || !T_map_node) continue;
    Target target;
    target.submap_id = id;
    target.T_submap_base = T_map_anchor->inverse() * *T_map_node;
    const Eigen::Vector2d p = target.T_submap_base.translation().head<2>();
    target.distance_m = 1e9;
    for (const SubmapStore::Member& member : submap.members)
      target.distance_m = std::min(target.distance_m, std::hypot(p.x() - member.T_submap_base.x,
                                                                 p.y() - member.T_submap_base.y));
    if (target.distance_m > config.near_m + config.max_window_m) continue;
    if (!paths) paths = graph_.paths_from(node);
    const auto known = graph_.relative(&*paths, node, anchor);
    if (!known) continue;
    const Matrix6d covariance = inverse_covariance(known->covariance, known->T_from_to);
    const double window_m = config.sigmas * worst_sigma_m(covariance);
    const double window_rad = config.sigmas * std::sqrt(covariance(5, 5));
    target.capped = window_m > config.max_window_m || window_rad > config.max_window_rad;
    target.window_m = std::clamp(window_m, config.min_window_m, config.max_window_m);
    target.window_rad = std::clamp(window_rad, config.min_window_rad, config.max_window_rad);
    target.connected = known->connected;
    if (!target.connected) {
      target.window_m = config.max_window_m;
      target.window_rad = M_PI;
      target.capped = true;
    }
    if (target.distance_m <= config.near_m + target.window_m) found.push_back(target);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Target& a, const Target& b) { return a.distance_m < b.distance_m; });
  if (found.size() > static_cast<std::size_t>(config.most_submaps))
    found.resize(static_cast<std::size_t>(config.most_submaps));
  return found;
}

std::vector<LoopCandidate> LoopDetector::search(const LoopScan& scan, const Target& target) {
  const UnpackedSubmap* submap = submaps_.unpacked(target.submap_id);
  if (submap == nullptr) return {};
  ++counts_.lidar_searches;
  const SearchWindow window{target.window_m, target.window_rad, 0.05};
  LidarCheck check =
      check_scan(*submap, scan.points_base, to_se2(target.T_submap_base), window, config_.lidar);
  if (!target.connected && check.opinion == LidarOpinion::kFits) {
    const std::string rival = rival_elsewhere(scan, target, check.T_submap_base);
    if (!rival.empty()) {
      check.opinion = LidarOpinion::kNothing;
      check.reason = rival;
    }
  }
  if (check.opinion == LidarOpinion::kNowhere || check.score < config_.lidar.min_agreement)
    return {};  // it is somewhere else: no idea to report

  LoopCandidate candidate;
  candidate.from = {NodeKind::kLidar, target.submap_id};
  candidate.to = {NodeKind::kLidar, scan.id};
  candidate.utime_us = scan.utime_us;
  candidate.source = LoopSource::kLidar;
  const char* why = "not asked: the LiDAR found it";
  candidate.stages.push_back({"appearance", 0.0, 0.0, false, why});
  candidate.stages.push_back({"geometry", 0.0, 0.0, false, why});
  const bool fits = check.opinion == LidarOpinion::kFits;
  candidate.stages.push_back(
      {"lidar", check.score, config_.lidar.min_agreement, fits, check.reason});
  if (!fits) return weigh(std::move(candidate), 0);
  candidate.measurements.push_back({candidate.from,
                                    candidate.to,
                                    to_se3(check.T_submap_base),
                                    full_covariance(check.covariance, config_.lidar, robot_.planar),
                                    {},
                                    "lidar loop"});
  const bool same_place = target.window_m <= config_.search.same_place_m && !target.capped;
  const int alike = same_place ? 1 : config_.search.loops_alike + (target.capped ? 1 : 0);
  return weigh(std::move(candidate), alike);
}

}  // namespace fusion_slam
