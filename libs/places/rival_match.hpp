// Is there another place in the window where a scan fits about as well? A corridor with equal
// doors, or a wall to slide along, has one; then the best match means little.
#pragma once

#include <optional>

#include "libs/scan_matching/correlative_matcher.hpp"

namespace fusion_slam {

struct RivalZone {  // poses that count as the same match
  double apart_m = 0.5;
  double apart_rad = 0.35;
};

// The best pose of the window outside the zone around `best` with a score above min_score, by
// branch and bound on the pyramid's upper bounds; nothing when there is none. No penalty for
// distance from the prediction. Pure.
std::optional<CorrelativeMatch> find_rival(const SearchPyramid& pyramid, const Points& points_base,
                                           const SE2& T_grid_base_predicted,
                                           const SearchWindow& window, const SE2& best,
                                           const RivalZone& zone, double min_score);

// Mean match probability of the points at a pose: what match_correlative maximises, less its
// penalty.
double match_score(const SearchPyramid& pyramid, const Points& points_base, const SE2& T_grid_base);

}  // namespace fusion_slam
