// Stage 3: does a scan fit into a submap, where, how surely, and nowhere else?
#pragma once

#include <string>

#include "libs/scan_matching/correlative_matcher.hpp"
#include "libs/scan_matching/overlap.hpp"
#include "services/loop_detector/config.hpp"
#include "services/loop_detector/submap_store.hpp"

namespace fusion_slam {

enum class LidarOpinion {
  kFits,     // one place in the window, and it is well fixed
  kNothing,  // it can't say: too few points, outside the map, two places alike, a bare corridor
  kNowhere,  // it sees known space, and fits nowhere in the window
};

struct LidarCheck {
  LidarOpinion opinion = LidarOpinion::kNothing;
  SE2 T_submap_base;                                         // kFits only
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // of it: x, y, yaw in base axes
  double score = 0.0;                                        // share of points that agree
  std::string reason;
};

// Branch-and-bound search of the whole window (Hess et al. 2016, V), a second one for a rival,
// refinement, and a count of the points that agree with the submap. Pure: equal input, equal bits.
LidarCheck check_scan(const UnpackedSubmap& submap, const Points& points_base,
                      const SE2& T_submap_base_predicted, const SearchWindow& window,
                      const LidarCheckConfig& config);

}  // namespace fusion_slam
