// Absolute and relative pose error of an estimated trajectory (Sturm et al. 2012, as evo 1.36.5
// computes them). This is the entry for other programs:
//   const auto ape = evaluate_ape(read_tum(ref).trajectory, read_tum(est).trajectory, options);
//   if (ape) use(ape->statistics.rmse, ape->coverage.percent); else report(ape.problem);
// Pure functions, callable from any thread. Trajectories are ordered by time, as read_tum() leaves
// them.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "libs/evaluation/alignment.hpp"
#include "libs/evaluation/association.hpp"
#include "libs/evaluation/coverage.hpp"
#include "libs/evaluation/outcome.hpp"
#include "libs/evaluation/pose_error.hpp"
#include "libs/evaluation/pose_pairs.hpp"
#include "libs/evaluation/statistics.hpp"
#include "libs/evaluation/trajectory.hpp"

namespace fusion_slam {

struct EvaluationOptions {
  Alignment alignment = Alignment::kNone;
  ErrorRelation relation = ErrorRelation::kTranslation;
  double max_diff_s = 0.01;          // the field's usual bound for 30 Hz cameras
  std::optional<TimeWindow> window;  // of coverage only; default: the whole reference
};

struct RelativeOptions {
  double delta = 1.0;
  DeltaUnit unit = DeltaUnit::kFrames;
  bool all_pairs = false;
};

// One compared error and the matched poses it belongs to: from == to for the absolute error.
struct ErrorSample {
  double error = 0.0;
  std::size_t from = 0;
  std::size_t to = 0;
};

struct TrajectoryError {
  Statistics statistics;             // unit_of(relation)
  std::vector<ErrorSample> samples;  // in the order of time of `from`
  MatchedPoses matched;              // the estimate already aligned
  Similarity alignment;              // what aligned it
  Coverage coverage;
};

// E_i = estimate_i^-1 * reference_i, for every matched pose.
// Fails: nothing matches in time, or no alignment (see umeyama()).
Outcome<TrajectoryError> evaluate_ape(const Trajectory& reference, const Trajectory& estimate,
                                      const EvaluationOptions& options);

// E_ij = (reference_i^-1 * reference_j)^-1 * (estimate_i^-1 * estimate_j), for the pairs of
// select_pairs() on the aligned estimate (the alignment matters only by its scale). Fails also for
// a bad delta and when delta yields no pair.
Outcome<TrajectoryError> evaluate_rpe(const Trajectory& reference, const Trajectory& estimate,
                                      const EvaluationOptions& options,
                                      const RelativeOptions& relative);

}  // namespace fusion_slam
