// Which pose of the estimate belongs to which pose of the reference: by nearest time.
#pragma once

#include <cstddef>
#include <vector>

#include "libs/evaluation/outcome.hpp"
#include "libs/evaluation/trajectory.hpp"

namespace fusion_slam {

// Index of the pose whose time is nearest to time_s; of equally near ones the first. `trajectory`
// is not empty.
std::size_t nearest_in_time(const Trajectory& trajectory, double time_s);

struct TimeMatch {
  std::size_t reference = 0;
  std::size_t estimate = 0;
};

// As evo 1.36.5 does it: each pose of the shorter trajectory (the estimate, when both are equally
// long) takes the nearest pose of the longer one, if that is no further than max_diff_s
// (inclusive). A pose of the longer one may be taken twice. Ordered by time.
std::vector<TimeMatch> associate(const Trajectory& reference, const Trajectory& estimate,
                                 double max_diff_s);

// Poses that belong together, index by index.
struct MatchedPoses {
  Trajectory reference;
  Trajectory estimate;

  std::size_t size() const { return estimate.size(); }
};

// associate() with the poses themselves. Fails when nothing matches, and says how far apart the
// times are.
Outcome<MatchedPoses> match_poses(const Trajectory& reference, const Trajectory& estimate,
                                  double max_diff_s);

}  // namespace fusion_slam
