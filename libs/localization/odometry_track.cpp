#include "libs/localization/odometry_track.hpp"

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
  return pose_at(poses_, utime_us, kMaxGapUs);
}

}  // namespace fusion_slam
