// Where a track is put that starts, or starts anew after it was lost.
#include <algorithm>

#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {
namespace {

constexpr double kUsToS = 1e-6;

Matrix6d diagonal(double translation_m, double rotation_rad) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(translation_m * translation_m),
      Eigen::Vector3d::Constant(rotation_rad * rotation_rad);
  return d.asDiagonal();
}

Matrix6d odometry_covariance(const PoseGraphConfig& config, const SE3& motion) {
  const double distance_m = motion.translation().norm();
  const double turn_rad = log_so3(motion.linear()).norm();
  return diagonal(config.odometry_slip * distance_m,
                  config.odometry_turn_slip * turn_rad + config.odometry_slip * distance_m);
}

Matrix6d restart_covariance(const PoseGraphConfig& config, double blind_s) {
  return diagonal(config.restart_translation_m + config.restart_speed_mps * blind_s,
                  config.restart_rotation_rad + config.restart_turn_radps * blind_s);
}

}  // namespace

// Between two poses gap_s apart the path may have bent: at most a * gap^2 / 8 off the straight
// line.
Matrix6d interpolated_covariance(const PoseGraphConfig& config, const TrackAnswer& answer) {
  const double gap_s = static_cast<double>(answer.gap_us) * kUsToS;
  return answer.pose.covariance +
         diagonal(config.max_acceleration_mps2 * gap_s * gap_s / 8.0,
                  config.max_angular_acceleration_radps2 * gap_s * gap_s / 8.0);
}

// Can this sensor still say where the robot was at that time?
bool PoseGraph::may_still_come(NodeKind sensor, std::int64_t utime_us) const {
  if (finishing_ || track(sensor).reaches(utime_us)) return false;
  if (robot_ && !(sensor == NodeKind::kLidar ? robot_->has_lidar : robot_->has_camera))
    return false;
  return newest_utime_us_ - utime_us <= config_.max_interpolation_gap_us;
}

// Nothing: wait, the other sensor will know better soon.
std::optional<PoseGraph::Hang> PoseGraph::hang(const NodeInput& node) const {
  if (auto found = hang_on_other_sensor(node)) return found;
  const NodeKind other = node.id.kind == NodeKind::kLidar ? NodeKind::kKeyframe : NodeKind::kLidar;
  if (may_still_come(other, node.utime_us)) return std::nullopt;
  return hang_on_last_known(node);
}

std::optional<PoseGraph::Hang> PoseGraph::hang_on_other_sensor(const NodeInput& node) const {
  const bool lidar = node.id.kind == NodeKind::kLidar;
  const auto seen = (lidar ? visual_ : lidar_).at(node.utime_us);
  if (!seen || !known(seen->pose.reference)) return std::nullopt;
  Hang found;
  found.edge = {lidar ? EdgeKind::kVisual : EdgeKind::kTie,
                seen->pose.reference,
                node.id,
                seen->pose.T_reference_base,
                interpolated_covariance(config_, *seen),
                1.0};
  return found;
}

// By wheels; else where the tracker itself believes to have gone on; else where the robot was last.
PoseGraph::Hang PoseGraph::hang_on_last_known(const NodeInput& node) const {
  const auto usable = [&](const TrackPose& p) { return known(p.reference); };
  const TrackPose* own = track(node.id.kind).newest_until(node.utime_us, usable);
  const NodeKind other_kind =
      node.id.kind == NodeKind::kLidar ? NodeKind::kKeyframe : NodeKind::kLidar;
  const TrackPose* other = track(other_kind).newest_until(node.utime_us, usable);
  const bool own_is_last = own != nullptr && (other == nullptr || own->utime_us >= other->utime_us);

  TrackPose last;
  if (own != nullptr || other != nullptr) {
    last = own_is_last ? *own : *other;
  } else {  // no pose at all: the newest node before it, or the first there is
    auto it = by_time_.upper_bound({node.utime_us, node.id});
    if (it != by_time_.begin()) --it;
    last.utime_us = it->first;
    last.reference = it->second;
    last.T_odom_base = nodes_.at(it->second).T_odom_base;
    last.covariance.setZero();
  }
  const bool same_odom_frame = last.reference.kind == node.id.kind;

  Hang found;
  found.counts_as_restart = true;
  GraphEdge& edge = found.edge;
  edge = {EdgeKind::kRestart, last.reference, node.id, last.T_reference_base, last.covariance, 1.0};
  if (const auto motion = odometry_.motion(last.utime_us, node.utime_us)) {
    edge.kind = EdgeKind::kOdometry;
    edge.T_from_to = last.T_reference_base * *motion;
    edge.covariance += odometry_covariance(config_, *motion);
    return found;
  }
  if (same_odom_frame)
    edge.T_from_to = last.T_reference_base * last.T_odom_base.inverse() * node.T_odom_base;
  const double blind_s =
      static_cast<double>(std::max<std::int64_t>(0, node.utime_us - last.utime_us)) * kUsToS;
  edge.covariance += restart_covariance(config_, blind_s);
  return found;
}

}  // namespace fusion_slam
