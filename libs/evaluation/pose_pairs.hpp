// Which two poses of one trajectory a relative error is measured between.
#pragma once

#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "libs/evaluation/trajectory.hpp"

namespace fusion_slam {

enum class DeltaUnit { kFrames, kMeters, kDegrees };

std::string_view name_of(DeltaUnit unit);  // "frames", "m", "deg"

using IndexPair = std::pair<std::size_t, std::size_t>;  // earlier, later

// The rules of evo 1.36.5 (its golden numbers test them), applied to the aligned estimate.
//            consecutive                                           all pairs
// frames     0, d, 2d, ...                                         (i, i + d) for every i
// m          path cut at the first pose >= d after the last cut;   for every i the j whose path
// from i is nearest
//            the piece before the first cut is not used            to d, if within 10 % of d
// deg        as m with summed rotation angles, but from pose 0     every (i, j) whose direct angle
// is within 10 % of d delta > 0; frames: whole. Degrees: at most 180. Ordered by the first index.
std::vector<IndexPair> select_pairs(const Trajectory& trajectory, double delta, DeltaUnit unit,
                                    bool all_pairs);

}  // namespace fusion_slam
