#include "libs/evaluation/coverage.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

constexpr double kBridgedPeriods = 3.0;
// A robot at walking speed is somewhere else after a second without a pose.
constexpr double kLongestBridge_s = 1.0;

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

bool has_pose_within(const Trajectory& trajectory, const TimeWindow& window) {
  return std::any_of(trajectory.begin(), trajectory.end(), [&](const StampedPose& pose) {
    return window.begin_s <= pose.time_s && pose.time_s <= window.end_s;
  });
}

// Share of [from, to] inside the window.
double clipped_s(const TimeWindow& window, double from_s, double to_s) {
  return std::max(0.0, std::min(to_s, window.end_s) - std::max(from_s, window.begin_s));
}

}  // namespace

Coverage compute_coverage(const Trajectory& reference, const Trajectory& estimate,
                          const std::optional<TimeWindow>& window) {
  Coverage coverage;
  if (window) {
    coverage.window = *window;
  } else if (!reference.empty()) {
    coverage.window = {reference.front().time_s, reference.back().time_s};
  }
  coverage.longest_gap_s = coverage.window.length_s();
  if (estimate.empty()) return coverage;
  coverage.allowed_gap_s =
      std::min(kBridgedPeriods * median_period_s(estimate),
               std::max(kLongestBridge_s, kBridgedPeriods * median_period_s(reference)));

  const TimeWindow& asked = coverage.window;
  coverage.longest_gap_s = std::max(clipped_s(asked, asked.begin_s, estimate.front().time_s),
                                    clipped_s(asked, estimate.back().time_s, asked.end_s));
  for (std::size_t i = 1; i < estimate.size(); ++i) {
    const double from_s = estimate[i - 1].time_s;
    const double to_s = estimate[i].time_s;
    const double inside_s = clipped_s(asked, from_s, to_s);
    coverage.longest_gap_s = std::max(coverage.longest_gap_s, inside_s);
    if (to_s - from_s <= coverage.allowed_gap_s) coverage.covered_s += inside_s;
  }
  if (asked.length_s() > 0.0) {
    coverage.percent = std::min(100.0, 100.0 * coverage.covered_s / asked.length_s());
  } else if (has_pose_within(estimate, asked)) {
    coverage.percent = 100.0;
  }
  return coverage;
}

}  // namespace fusion_slam
