// Where in a whole map does what the LiDAR saw fit, how well, and where else? Pure functions.
#pragma once

#include <string>

#include "libs/localization/localization_map.hpp"
#include "libs/scan_matching/correlative_matcher.hpp"

namespace fusion_slam {

struct LidarFix {
  bool found = false;
  SE2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // x, y, yaw in base axes
  double score = 0.0;        // mean match probability in the coarse map
  double agreement = 0.0;    // share of the points in known space that hit something known
  double coverage = 0.0;     // share of the points in known space
  double rival_score = 0.0;  // the best other place's; 0: none above rival_share of the score
  std::string reason;        // when not found
};

// The best place of the map, by branch and bound over every position and heading (Hess et al. 2016,
// V; Olson 2009), refined on the map's own cells; and the best other place that scores at least
// `rival_share` as much; 1: nobody asks.
LidarFix find_in_map(const MapGrid& map, const Points& points_base, double rival_share,
                     const MapSearchConfig& config);

// The best place near a prediction. No rival is looked for.
LidarFix find_near(const MapGrid& map, const Points& points_base, const SE2& T_map_base_predicted,
                   const SearchWindow& window, const MapSearchConfig& config);

}  // namespace fusion_slam
