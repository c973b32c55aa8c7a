#include "libs/geometry/timed_poses.hpp"

#include <iterator>

namespace fusion_slam {

std::optional<SE3> pose_at(const TimedPoses& poses, std::int64_t utime_us,
                           std::int64_t max_gap_us) {
  const auto after = poses.lower_bound(utime_us);
  if (after == poses.end()) return std::nullopt;
  if (after->first == utime_us) return after->second;
  if (after == poses.begin()) return std::nullopt;
  const auto before = std::prev(after);
  // Unsigned: two times may be further apart than an int64 can say.
  const std::uint64_t start_us = static_cast<std::uint64_t>(before->first);
  const std::uint64_t gap_us = static_cast<std::uint64_t>(after->first) - start_us;
  if (gap_us > static_cast<std::uint64_t>(max_gap_us)) return std::nullopt;
  const std::uint64_t since_us = static_cast<std::uint64_t>(utime_us) - start_us;
  return interpolate(before->second, after->second,
                     static_cast<double>(since_us) / static_cast<double>(gap_us));
}

}  // namespace fusion_slam
