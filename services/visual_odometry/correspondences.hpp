// From a point in space and a feature to what the pose estimators take.
#pragma once

#include "libs/features/correspondence.hpp"
#include "libs/features/feature.hpp"

namespace fusion_slam {

inline Correspondence make_correspondence(const Eigen::Vector3d& p_odom, const Feature& feature,
                                          double pixel_sigma) {
  Correspondence c;
  c.p_reference = p_odom;
  c.pixel = {feature.u_px, feature.v_px};
  c.pixel_sigma = pixel_sigma;
  c.depth_m = feature.depth_m;
  c.depth_sigma_m = feature.depth_sigma_m;
  return c;
}

}  // namespace fusion_slam
