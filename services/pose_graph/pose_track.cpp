#include "services/pose_graph/pose_track.hpp"

#include <iterator>

namespace fusion_slam {

void PoseTrack::add(const TrackPose& pose) {
  TrackPose& stored = poses_[pose.utime_us] = pose;
  stored.after_break = broken_;
  broken_ = false;
  const std::int64_t oldest = poses_.rbegin()->first - memory_us_;
  poses_.erase(poses_.begin(), poses_.lower_bound(oldest));
}

std::optional<TrackAnswer> PoseTrack::at(std::int64_t utime_us) const {
  const auto after = poses_.lower_bound(utime_us);
  if (after == poses_.end()) return std::nullopt;
  if (after->first == utime_us) return TrackAnswer{after->second, 0};
  if (after == poses_.begin()) return std::nullopt;
  const TrackPose& a = std::prev(after)->second;
  const TrackPose& b = after->second;
  const std::int64_t gap_us = b.utime_us - a.utime_us;
  if (b.after_break || gap_us > max_gap_us_) return std::nullopt;

  const double fraction = static_cast<double>(utime_us - a.utime_us) / static_cast<double>(gap_us);
  TrackAnswer answer{a, gap_us};
  answer.pose.utime_us = utime_us;
  answer.pose.T_odom_base = interpolate(a.T_odom_base, b.T_odom_base, fraction);
  answer.pose.T_reference_base =
      a.T_reference_base * a.T_odom_base.inverse() * answer.pose.T_odom_base;
  return answer;
}

const TrackPose* PoseTrack::newest_until(std::int64_t utime_us,
                                         const std::function<bool(const TrackPose&)>& fits) const {
  for (auto it = poses_.upper_bound(utime_us); it != poses_.begin();)
    if (fits((--it)->second)) return &it->second;
  return nullptr;
}

void PoseTrack::forget_from(std::int64_t utime_us) {
  poses_.erase(poses_.lower_bound(utime_us), poses_.end());
  broken_ = true;
}

bool PoseTrack::reaches(std::int64_t utime_us) const {
  return !poses_.empty() && poses_.rbegin()->first >= utime_us;
}

std::optional<SE3> PoseTrack::motion(std::int64_t from_us, std::int64_t to_us) const {
  const auto from = at(from_us);
  const auto to = at(to_us);
  if (!from || !to) return std::nullopt;
  for (auto it = poses_.upper_bound(from_us); it != poses_.end() && it->first <= to_us; ++it)
    if (it->second.after_break) return std::nullopt;
  return from->pose.T_odom_base.inverse() * to->pose.T_odom_base;
}

}  // namespace fusion_slam
