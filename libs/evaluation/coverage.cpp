#include "libs/evaluation/coverage.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

constexpr double kBridgedPeriods = 3.0;
// A robot at walking speed is somewhere else after a second without a pose.
constexpr double kLongestBridge_s = 1.0;

// Scans of a real log (fr079) pause for up to 2.3 s.
constexpr double kLongestPause_s = 2.5;

bool has_pose_inside(const Trajectory& trajectory, const TimeWindow& gap) {
  const auto after = std::upper_bound(trajectory.begin(), trajectory.end(), gap.begin_s,
                                      [](double t, const StampedPose& p) { return t < p.time_s; });
  return after != trajectory.end() && after->time_s < gap.end_s;
}

bool has_pose_within(const Trajectory& trajectory, const TimeWindow& window) {
  return std::any_of(trajectory.begin(), trajectory.end(), [&](const StampedPose& pose) {
    return window.begin_s <= pose.time_s && pose.time_s <= window.end_s;
  });
}

TimeWindow intersection(const TimeWindow& a, const TimeWindow& b) {
  return {std::max(a.begin_s, b.begin_s), std::min(a.end_s, b.end_s)};
}

// Takes notice of a time without a pose inside it.
void count_gap(const TimeWindow& gap, bool bridged, Coverage& coverage) {
  const TimeWindow inside = intersection(gap, coverage.window);
  if (inside.length_s() <= 0.0) return;
  coverage.longest_gap_s = std::max(coverage.longest_gap_s, inside.length_s());
  if (bridged) {
    coverage.covered_s += inside.length_s();
  } else {
    coverage.lost.push_back(inside);
  }
}

double percent_covered(const Coverage& coverage, const Trajectory& estimate) {
  const double asked_s = coverage.window.length_s();
  if (asked_s > 0.0) return std::min(100.0, 100.0 * coverage.covered_s / asked_s);
  return has_pose_within(estimate, coverage.window) ? 100.0 : 0.0;
}

}  // namespace

double median_period_s(const Trajectory& trajectory) {
  std::vector<double> periods;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const double period_s = trajectory[i].time_s - trajectory[i - 1].time_s;
    if (period_s > 0.0) periods.push_back(period_s);
  }
  if (periods.empty()) return 0.0;
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  return *middle;
}

Coverage compute_coverage(const Trajectory& reference, const Trajectory& estimate,
                          const std::optional<TimeWindow>& window) {
  Coverage coverage;
  if (window) {
    coverage.window = *window;
  } else if (!reference.empty()) {
    coverage.window = {reference.front().time_s, reference.back().time_s};
  }
  if (estimate.empty()) {
    count_gap(coverage.window, false, coverage);
    return coverage;
  }
  coverage.allowed_gap_s =
      std::min(kBridgedPeriods * median_period_s(estimate),
               std::max(kLongestBridge_s, kBridgedPeriods * median_period_s(reference)));
  count_gap({coverage.window.begin_s, estimate.front().time_s}, false, coverage);
  for (std::size_t i = 1; i < estimate.size(); ++i) {
    const TimeWindow gap{estimate[i - 1].time_s, estimate[i].time_s};
    const bool short_enough = gap.length_s() <= coverage.allowed_gap_s;
    const bool pause = gap.length_s() <= kLongestPause_s && !has_pose_inside(reference, gap);
    count_gap(gap, short_enough || pause, coverage);
  }
  count_gap({estimate.back().time_s, coverage.window.end_s}, false, coverage);
  coverage.percent = percent_covered(coverage, estimate);
  return coverage;
}

}  // namespace fusion_slam
