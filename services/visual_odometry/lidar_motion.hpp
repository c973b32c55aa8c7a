// How the robot moved between two times, as the LiDAR mapper believes: what predicts the camera's
// motion when vision is weak, and bridges while it is lost.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

class LidarMotion {
 public:
  // A LIDAR_POSE that was measured (state OK or WEAK), in the LiDAR's own odom. Older than the
  // newest or the same: ignored.
  void add(std::int64_t utime_us, const SE3& T_odom_base);
  void clear() { poses_.clear(); }

  // T_from_to of base: interpolated between poses, carried on with the last velocity beyond the
  // newest. Nothing when either time is not within 0.3 s of a pose.
  std::optional<SE3> between(std::int64_t from_us, std::int64_t to_us) const;

 private:
  std::optional<SE3> at(std::int64_t utime_us) const;

  std::map<std::int64_t, SE3> poses_;  // the last few seconds
};

}  // namespace fusion_slam
