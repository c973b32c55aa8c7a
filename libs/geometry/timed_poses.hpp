// Poses by their time, and the pose between two of them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// utime (us) -> T_frame_body of one frame and one body.
using TimedPoses = std::map<std::int64_t, SE3>;

// The pose at utime_us: the one of that time, or interpolated between its neighbours. None before
// the first, after the last, and between two that are further apart than max_gap_us. Any times will
// do, those of hostile messages too. Pure: any thread.
std::optional<SE3> pose_at(const TimedPoses& poses, std::int64_t utime_us, std::int64_t max_gap_us);

}  // namespace fusion_slam
