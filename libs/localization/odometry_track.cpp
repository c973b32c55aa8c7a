#include "libs/localization/odometry_track.hpp"

#include <iterator>

namespace fusion_slam {
namespace {

constexpr std::int64_t kMemoryUs = 20'000'000;
constexpr std::int64_t kMaxGapUs = 500'000;  // a longer gap is no trajectory

}  // namespace

void OdometryTrack::add(std::int64_t utime_us, const SE3& T_odom_base) {
  poses_[utime_us] = T_odom_base;
  poses_.erase(poses_.begin(), poses_.lower_bound(poses_.rbegin()->first - kMemoryUs));
}

std::optional<SE3> OdometryTrack::at(std::int64_t utime_us) const {
  const auto after = poses_.lower_bound(utime_us);
  if (after == poses_.end()) return std::nullopt;
  if (after->first == utime_us) return after->second;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const std::int64_t gap_us = after->first - before->first;
  if (gap_us > kMaxGapUs) return std::nullopt;
  return interpolate(before->second, after->second,
                     static_cast<double>(utime_us - before->first) / static_cast<double>(gap_us));
}

}  // namespace fusion_slam
