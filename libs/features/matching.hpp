// Matching of descriptors without any idea of the motion.
#pragma once

#include <vector>

#include "libs/features/feature.hpp"

namespace fusion_slam {

struct Match {
  int a = 0;
  int b = 0;
  int distance = 0;
};

struct MatchConfig {
  int max_distance = 60;  // bits: unrelated rBRIEF descriptors differ in about 128 +- 20
  double ratio = 0.8;     // best / second best (Lowe 2004, section 7.1)
};

// Pairs that are each other's nearest neighbour and clearly nearer than the second nearest;
// ascending in a. Exhaustive: |a| * |b| comparisons.
std::vector<Match> match_mutual(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                const MatchConfig& config = {});

// Of the matches, those whose change of orientation agrees with the most common one (a camera's
// roll turns all features by the same angle): the fullest 30 degree window of the differences.
std::vector<Match> keep_common_rotation(const std::vector<Match>& matches,
                                        const std::vector<float>& angles_a_rad,
                                        const std::vector<float>& angles_b_rad);

}  // namespace fusion_slam
