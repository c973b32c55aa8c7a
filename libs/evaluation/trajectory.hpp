// A trajectory as an evaluation sees it: poses in one fixed frame, ordered by time.
#pragma once

#include <vector>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// time_s is seconds since any epoch, as a double: of Unix times it resolves 0.24 us, so that a
// utime in microseconds survives there and back. T_world_body: metres, whatever "world" and "body"
// the file means.
struct StampedPose {
  double time_s = 0.0;
  SE3 T_world_body = SE3::Identity();
};

// Every function of libs/evaluation expects the order of time (equal times allowed).
using Trajectory = std::vector<StampedPose>;

// Half-open questions such as "how much of this recording" are asked about [begin_s, end_s].
struct TimeWindow {
  double begin_s = 0.0;
  double end_s = 0.0;

  double length_s() const { return end_s - begin_s; }
};

}  // namespace fusion_slam
