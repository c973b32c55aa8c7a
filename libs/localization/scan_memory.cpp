#include "libs/localization/scan_memory.hpp"

#include <cmath>

namespace fusion_slam {

void ScanMemory::add(std::int64_t utime_us, const SE2& T_odom_base, const Points& points_base) {
  scans_.push_back({utime_us, T_odom_base, points_base});
  double way_m = 0.0;
  for (std::size_t i = scans_.size() - 1; i > 0; --i) {
    way_m += std::hypot(scans_[i].T_odom_base.x - scans_[i - 1].T_odom_base.x,
                        scans_[i].T_odom_base.y - scans_[i - 1].T_odom_base.y);
    const bool too_far = way_m > config_.memory_m;
    const bool too_old = utime_us - scans_[i - 1].utime_us > config_.memory_us;
    if (!too_far && !too_old) continue;
    scans_.erase(scans_.begin(), scans_.begin() + static_cast<std::ptrdiff_t>(i));
    return;
  }
}

Points ScanMemory::points_base() const {
  Points all;
  if (scans_.empty()) return all;
  const SE2 T_base_odom = scans_.back().T_odom_base.inverse();
  for (const Scan& scan : scans_) {
    const SE2 T_base_then = T_base_odom * scan.T_odom_base;
    for (const auto& p : scan.points_base) all.push_back(T_base_then * p);
  }
  return all;
}

}  // namespace fusion_slam
