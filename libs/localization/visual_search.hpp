// Which keyframes of a map show what the camera sees now, and where is the robot then? Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/localization/localization_map.hpp"

namespace fusion_slam {

struct VisualFix {
  std::int64_t keyframe_id = 0;  // of the map
  SE3 T_map_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // base axes; of the match, not of the map
  int n_inliers = 0;
};

// Appearance first, then geometry (as the loop detector's stages 1 and 2): those that pass, most
// inliers first. Empty: the map knows no such view.
std::vector<VisualFix> find_views(const LocalizationMap& map, const FeatureSet& features);

}  // namespace fusion_slam
