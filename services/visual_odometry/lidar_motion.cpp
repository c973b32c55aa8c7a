#include "services/visual_odometry/lidar_motion.hpp"

#include <iterator>

namespace fusion_slam {
namespace {

constexpr std::int64_t kKept_us = 5'000'000;
constexpr std::int64_t kReach_us = 300'000;  // two scans of a slow LiDAR

}  // namespace

void LidarMotion::add(std::int64_t utime_us, const SE3& T_odom_base) {
  if (!poses_.empty() && utime_us <= poses_.rbegin()->first) return;
  poses_.emplace(utime_us, T_odom_base);
  while (poses_.begin()->first < utime_us - kKept_us) poses_.erase(poses_.begin());
}

std::optional<SE3> LidarMotion::at(std::int64_t utime_us) const {
  if (poses_.size() < 2) return std::nullopt;
  auto next = poses_.lower_bound(utime_us);
  if (next == poses_.begin()) {
    if (next->first - utime_us > kReach_us) return std::nullopt;
    ++next;
  }
  if (next == poses_.end()) {
    --next;
    if (utime_us - next->first > kReach_us) return std::nullopt;
  }
  const auto previous = std::prev(next);
  const std::int64_t gap_us = next->first - previous->first;
  if (gap_us > 2 * kReach_us) return std::nullopt;
  const double fraction = static_cast<double>(utime_us - previous->first) / gap_us;
  return interpolate(previous->second, next->second, fraction);
}

std::optional<SE3> LidarMotion::between(std::int64_t from_us, std::int64_t to_us) const {
  const std::optional<SE3> from = at(from_us);
  const std::optional<SE3> to = at(to_us);
  if (!from || !to) return std::nullopt;
  return from->inverse() * *to;
}

}  // namespace fusion_slam
