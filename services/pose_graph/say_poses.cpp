// POSE: where the robot is in the map, for each pose that a tracker says.
#include "services/pose_graph/pose_graph.hpp"

namespace fusion_slam {

// Poses whose node is known, in the order they came; those whose node doesn't come in time are
// bridged.
void PoseGraph::say_poses() {
  std::deque<PoseInput> still_waiting;
  for (PoseInput& pose : waiting_poses_) {
    const bool lost = pose.state == PoseState::kLost || pose.state == PoseState::kUnknown ||
                      !pose.reference || pose.reference->id == 0;
    const bool too_late = finishing_ || newest_utime_us_ - pose.utime_us > config_.max_wait_us ||
                          waiting_poses_.size() > config_.max_waiting;
    std::optional<PoseOutput> output;
    if (!lost && known(*pose.reference)) {
      output = said(pose);
    } else if (lost || too_late) {
      output = bridged(pose);
    } else {
      still_waiting.push_back(std::move(pose));
    }
    if (!output) continue;
    if (!last_pose_ || output->utime_us >= last_pose_->utime_us) last_pose_ = output;
    poses_.push_back(*output);
  }
  waiting_poses_.swap(still_waiting);
}

PoseOutput PoseGraph::said(const PoseInput& pose) const {
  PoseOutput output;
  output.utime_us = pose.utime_us;
  output.reference = *pose.reference;
  output.T_reference_base = pose.T_reference_base;
  output.T_map_base = T_map(output.reference) * pose.T_reference_base;
  output.covariance = rebuilding_  // nobody hears it
                          ? pose.covariance
                          : chained_covariance(map_covariance(output.reference),
                                               pose.T_reference_base, pose.covariance);
  output.state = pose.state;
  output.reason = pose.reason;
  output.fix_utime_us = pose.fix_utime_us;
  output.n_matched = pose.n_matched;
  return output;
}

// The tracker is lost. The other sensor knows (WEAK); or the wheels, from where the robot was last;
// or it is there still. Nothing: the robot's place was never known.
std::optional<PoseOutput> PoseGraph::bridged(const PoseInput& pose) const {
  const bool lidar = pose.sensor == NodeKind::kLidar;
  const PoseTrack& other = lidar ? visual_ : lidar_;
  const auto usable = [this](const TrackPose& p) { return known(p.reference); };

  PoseOutput output;
  output.utime_us = pose.utime_us;
  output.covariance = pose.covariance;
  output.state = PoseState::kLost;
  output.reason = pose.reason.empty() ? "the node this pose hangs on never came" : pose.reason;

  const TrackPose* near = other.newest_until(pose.utime_us, usable);
  if (near != nullptr && pose.utime_us - near->utime_us <= config_.max_interpolation_gap_us) {
    output.state = PoseState::kWeak;
    output.reason += lidar ? "; bridged by the camera" : "; bridged by the LiDAR";
    output.reference = near->reference;
    output.T_reference_base = near->T_reference_base;
    output.covariance = near->covariance;
    output.fix_utime_us = near->fix_utime_us;
    if (const auto seen = other.at(pose.utime_us); seen && known(seen->pose.reference)) {
      output.reference = seen->pose.reference;
      output.T_reference_base = seen->pose.T_reference_base;
    } else if (const auto motion = odometry_.motion(near->utime_us, pose.utime_us)) {
      output.T_reference_base = near->T_reference_base * *motion;
    }
  } else if (last_pose_) {
    output.reference = last_pose_->reference;
    output.T_reference_base = last_pose_->T_reference_base;
    output.fix_utime_us = last_pose_->fix_utime_us;
    if (const auto motion = odometry_.motion(last_pose_->utime_us, pose.utime_us)) {
      output.T_reference_base = last_pose_->T_reference_base * *motion;
      output.reason += "; by wheel odometry";
    }
  } else {
    return std::nullopt;
  }
  output.T_map_base = T_map(output.reference) * output.T_reference_base;
  output.covariance = chained_covariance(map_covariance(output.reference), output.T_reference_base,
                                         output.covariance);
  return output;
}

}  // namespace fusion_slam
