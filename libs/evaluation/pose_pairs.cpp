#include "libs/evaluation/pose_pairs.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

// How far from delta a pair of the all-pairs modes may be.
constexpr double kRelativeTolerance = 0.1;

double distance_m(const StampedPose& a, const StampedPose& b) {
  return (a.T_world_body.translation() - b.T_world_body.translation()).norm();
}

double angle_rad(const StampedPose& a, const StampedPose& b) {
  return log_so3(a.T_world_body.linear().transpose() * b.T_world_body.linear()).norm();
}

std::vector<IndexPair> by_frames(std::size_t count, double delta_frames, bool all_pairs) {
  std::vector<IndexPair> pairs;
  if (delta_frames >= static_cast<double>(count)) return pairs;
  const auto delta = static_cast<std::size_t>(delta_frames);
  const std::size_t step = all_pairs ? 1 : delta;
  for (std::size_t i = 0; i + delta < count; i += step) pairs.emplace_back(i, i + delta);
  return pairs;
}

std::vector<IndexPair> consecutive_by_path(const Trajectory& trajectory, double delta_m) {
  std::vector<std::size_t> cuts;
  double path_m = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    path_m += distance_m(trajectory[i - 1], trajectory[i]);
    if (path_m < delta_m) continue;
    cuts.push_back(i);
    path_m = 0.0;
  }
  std::vector<IndexPair> pairs;
  for (std::size_t k = 1; k < cuts.size(); ++k) pairs.emplace_back(cuts[k - 1], cuts[k]);
  return pairs;
}

// Path length from pose 0 never falls, so the nearest to a target is found by bisection. Of equally
// near ones (the robot stood still) the first.
std::vector<IndexPair> all_by_path(const Trajectory& trajectory, double delta_m) {
  std::vector<double> path_m(trajectory.size(), 0.0);
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    path_m[i] = path_m[i - 1] + distance_m(trajectory[i - 1], trajectory[i]);
  }
  std::vector<IndexPair> pairs;
  for (std::size_t i = 0; i + 1 < path_m.size(); ++i) {
    const auto first = path_m.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    const auto first_at_least = [&](double length_m) {
      return std::lower_bound(first, path_m.end(), length_m,
                              [&](double path, double l) { return path - path_m[i] < l; });
    };
    const auto off_m = [&](auto it) { return std::abs(*it - path_m[i] - delta_m); };
    auto best = first_at_least(delta_m);
    if (best == path_m.end() || (best != first && off_m(best - 1) <= off_m(best))) {
      best = first_at_least(*(best - 1) - path_m[i]);
    }
    if (off_m(best) > delta_m * kRelativeTolerance) continue;
    pairs.emplace_back(i, static_cast<std::size_t>(best - path_m.begin()));
  }
  return pairs;
}

std::vector<IndexPair> consecutive_by_angle(const Trajectory& trajectory, double delta_rad) {
  std::vector<IndexPair> pairs;
  std::size_t start = 0;
  double turned_rad = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    turned_rad += angle_rad(trajectory[i - 1], trajectory[i]);
    if (turned_rad < delta_rad) continue;
    pairs.emplace_back(start, i);
    start = i;
    turned_rad = 0.0;
  }
  return pairs;
}

std::vector<IndexPair> all_by_angle(const Trajectory& trajectory, double delta_rad) {
  const double tolerance_rad = delta_rad * kRelativeTolerance;
  std::vector<IndexPair> pairs;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    for (std::size_t j = i + 1; j < trajectory.size(); ++j) {
      const double angle = angle_rad(trajectory[i], trajectory[j]);
      if (delta_rad - tolerance_rad <= angle && angle <= delta_rad + tolerance_rad) {
        pairs.emplace_back(i, j);
      }
    }
  }
  return pairs;
}

}  // namespace

std::string_view name_of(DeltaUnit unit) {
  switch (unit) {
    case DeltaUnit::kFrames:
      return "frames";
    case DeltaUnit::kMeters:
      return "m";
    case DeltaUnit::kDegrees:
      return "deg";
  }
  return "";
}

std::vector<IndexPair> select_pairs(const Trajectory& trajectory, double delta, DeltaUnit unit,
                                    bool all_pairs) {
  switch (unit) {
    case DeltaUnit::kFrames:
      return by_frames(trajectory.size(), delta, all_pairs);
    case DeltaUnit::kMeters:
      return all_pairs ? all_by_path(trajectory, delta) : consecutive_by_path(trajectory, delta);
    case DeltaUnit::kDegrees: {
      const double delta_rad = delta * M_PI / 180.0;
      return all_pairs ? all_by_angle(trajectory, delta_rad)
                       : consecutive_by_angle(trajectory, delta_rad);
    }
  }
  return {};
}

}  // namespace fusion_slam
