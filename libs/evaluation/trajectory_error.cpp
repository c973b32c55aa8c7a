#include "libs/evaluation/trajectory_error.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace fusion_slam {
namespace {

// Matched, aligned and with coverage; the errors are still to come.
Outcome<TrajectoryError> prepare(const Trajectory& reference, const Trajectory& estimate,
                                 const EvaluationOptions& options) {
  Outcome<MatchedPoses> matched = match_poses(reference, estimate, options.max_diff_s);
  if (!matched) return Outcome<TrajectoryError>::failure(matched.problem);
  const Outcome<Similarity> S = find_alignment(*matched, options.alignment);
  if (!S) return Outcome<TrajectoryError>::failure(S.problem);

  TrajectoryError result;
  result.matched = std::move(*matched.value);
  result.matched.estimate = transform(*S, result.matched.estimate);
  result.alignment = *S;
  result.coverage = compute_coverage(reference, estimate, options.window);
  return Outcome<TrajectoryError>::success(std::move(result));
}

void summarize(TrajectoryError& result) {
  std::vector<double> errors;
  errors.reserve(result.samples.size());
  for (const ErrorSample& sample : result.samples) errors.push_back(sample.error);
  result.statistics = compute_statistics(errors);
}

std::string check(const RelativeOptions& relative) {
  if (!(relative.delta > 0.0) || !std::isfinite(relative.delta)) {
    return "the delta must be a number above 0";
  }
  if (relative.unit == DeltaUnit::kFrames && relative.delta != std::floor(relative.delta)) {
    return "a delta in frames must be a whole number";
  }
  if (relative.unit == DeltaUnit::kDegrees && relative.delta > 180.0) {
    return "a delta in deg can't exceed 180";
  }
  return {};
}

std::string explain_no_pair(const RelativeOptions& relative, std::size_t poses) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "no two of the %zu matched poses are %g %s apart; try a smaller --delta", poses,
                relative.delta, std::string(name_of(relative.unit)).c_str());
  return text.data();
}

}  // namespace

Outcome<TrajectoryError> evaluate_ape(const Trajectory& reference, const Trajectory& estimate,
                                      const EvaluationOptions& options) {
  Outcome<TrajectoryError> outcome = prepare(reference, estimate, options);
  if (!outcome) return outcome;
  TrajectoryError& result = *outcome.value;
  for (std::size_t i = 0; i < result.matched.size(); ++i) {
    const SE3 E = result.matched.estimate[i].T_world_body.inverse() *
                  result.matched.reference[i].T_world_body;
    result.samples.push_back({pose_error(E, options.relation), i, i});
  }
  summarize(result);
  return outcome;
}

Outcome<TrajectoryError> evaluate_rpe(const Trajectory& reference, const Trajectory& estimate,
                                      const EvaluationOptions& options,
                                      const RelativeOptions& relative) {
  if (const std::string problem = check(relative); !problem.empty()) {
    return Outcome<TrajectoryError>::failure(problem);
  }
  Outcome<TrajectoryError> outcome = prepare(reference, estimate, options);
  if (!outcome) return outcome;
  TrajectoryError& result = *outcome.value;
  const Trajectory& ref = result.matched.reference;
  const Trajectory& est = result.matched.estimate;
  for (const auto& [i, j] : select_pairs(est, relative.delta, relative.unit, relative.all_pairs)) {
    const SE3 T_ref_i_j = ref[i].T_world_body.inverse() * ref[j].T_world_body;
    const SE3 T_est_i_j = est[i].T_world_body.inverse() * est[j].T_world_body;
    result.samples.push_back({pose_error(T_ref_i_j.inverse() * T_est_i_j, options.relation), i, j});
  }
  if (result.samples.empty()) {
    return Outcome<TrajectoryError>::failure(explain_no_pair(relative, result.matched.size()));
  }
  summarize(result);
  return outcome;
}

}  // namespace fusion_slam
