// What a tracker said lately of the way, asked between its poses. It never extrapolates.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "libs/geometry/timed_poses.hpp"

namespace fusion_slam {

class OdometryTrack {
 public:
  void add(std::int64_t utime_us, const SE3& T_odom_base);
  void clear() { poses_.clear(); }  // the tracker lost itself: what comes is another odom frame

  std::optional<SE3> at(std::int64_t utime_us) const;
  bool reaches(std::int64_t utime_us) const {
    return !poses_.empty() && poses_.rbegin()->first >= utime_us;
  }

 private:
  TimedPoses poses_;  // of the latest seconds
};

}  // namespace fusion_slam
