#include "libs/evaluation/association.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace fusion_slam {
namespace {

Trajectory::const_iterator first_not_before(const Trajectory& trajectory, double time_s) {
  return std::lower_bound(trajectory.begin(), trajectory.end(), time_s,
                          [](const StampedPose& pose, double t) { return pose.time_s < t; });
}

std::string explain_no_match(const Trajectory& reference, const Trajectory& estimate,
                             double max_diff_s) {
  if (reference.empty()) return "the reference has no poses";
  if (estimate.empty()) return "the estimate has no poses";
  double closest_s = std::numeric_limits<double>::infinity();
  for (const StampedPose& pose : estimate) {
    const double nearest_s = reference[nearest_in_time(reference, pose.time_s)].time_s;
    closest_s = std::min(closest_s, std::abs(nearest_s - pose.time_s));
  }
  const bool overlap = estimate.front().time_s <= reference.back().time_s &&
                       reference.front().time_s <= estimate.back().time_s;
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(),
                "no pose of the estimate (%.3f s to %.3f s) is within %g s of a pose of the "
                "reference (%.3f s to "
                "%.3f s): the closest two are %.6g s apart; %s",
                estimate.front().time_s, estimate.back().time_s, max_diff_s,
                reference.front().time_s, reference.back().time_s, closest_s,
                overlap
                    ? "try a larger --max-diff"
                    : "the two don't overlap in time: are they of the same recording and clock?");
  return text.data();
}

}  // namespace

std::size_t nearest_in_time(const Trajectory& trajectory, double time_s) {
  auto after = first_not_before(trajectory, time_s);
  if (after == trajectory.begin()) return 0;
  const auto before = std::prev(after);
  const bool before_is_nearer = after == trajectory.end() || std::abs(before->time_s - time_s) <=
                                                                 std::abs(after->time_s - time_s);
  if (before_is_nearer) after = first_not_before(trajectory, before->time_s);
  return static_cast<std::size_t>(after - trajectory.begin());
}

std::vector<TimeMatch> associate(const Trajectory& reference, const Trajectory& estimate,
                                 double max_diff_s) {
  const bool reference_drives = estimate.size() > reference.size();
  const Trajectory& driving = reference_drives ? reference : estimate;
  const Trajectory& searched = reference_drives ? estimate : reference;
  std::vector<TimeMatch> matches;
  if (searched.empty()) return matches;
  for (std::size_t i = 0; i < driving.size(); ++i) {
    const std::size_t j = nearest_in_time(searched, driving[i].time_s);
    if (!(std::abs(searched[j].time_s - driving[i].time_s) <= max_diff_s)) continue;  // NaN: none
    matches.push_back(reference_drives ? TimeMatch{i, j} : TimeMatch{j, i});
  }
  return matches;
}

Outcome<MatchedPoses> match_poses(const Trajectory& reference, const Trajectory& estimate,
                                  double max_diff_s) {
  MatchedPoses matched;
  for (const TimeMatch& match : associate(reference, estimate, max_diff_s)) {
    matched.reference.push_back(reference[match.reference]);
    matched.estimate.push_back(estimate[match.estimate]);
  }
  if (matched.size() == 0) {
    return Outcome<MatchedPoses>::failure(explain_no_match(reference, estimate, max_diff_s));
  }
  return Outcome<MatchedPoses>::success(std::move(matched));
}

}  // namespace fusion_slam
