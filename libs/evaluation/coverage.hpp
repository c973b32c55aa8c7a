// How much of a recording an estimate covers. An accuracy without it says little: a tracker that
// gives up at the first difficulty has small errors.
#pragma once

#include <optional>
#include <vector>

#include "libs/evaluation/trajectory.hpp"

namespace fusion_slam {

// Coverage is a share of TIME, because a reference is often much denser (motion capture at 100 Hz
// and more) or much sparser than the estimate. The time between two consecutive poses of the
// estimate is covered when it is
//   at most allowed_gap_s = min(3 * median period of the estimate, max(1 s, 3 * median period of
//   the reference)), or at most 2.5 s and the reference has no pose inside it either (the sensor
//   paused, nobody expected a pose).
// So one or two missing poses are bridged and a longer loss counts as lost, in full; and an
// estimate of a few sparse poses is not covering unless the reference is as sparse. Nothing is
// credited before the first and after the last pose.
struct Coverage {
  double percent = 0.0;  // 100 * covered_s / window length
  double covered_s = 0.0;
  double allowed_gap_s = 0.0;
  double longest_gap_s = 0.0;    // longest time in the window without a pose, its two ends included
  TimeWindow window;             // what was asked about
  std::vector<TimeWindow> lost;  // the times in it that are not covered, in order
};

// `window`: the recording's own first and last measurement, when the caller knows them; otherwise
// the whole time span of the reference. A window of no length is covered (100) when an estimate
// pose is at that time.
Coverage compute_coverage(const Trajectory& reference, const Trajectory& estimate,
                          const std::optional<TimeWindow>& window = std::nullopt);

// Median time between consecutive poses whose times differ; 0 when there are none.
double median_period_s(const Trajectory& trajectory);

}  // namespace fusion_slam
