// From map points and features to what the pose estimators take.
#pragma once

#include "libs/camera/camera_model.hpp"
#include "libs/features/correspondence.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/local_map.hpp"

namespace fusion_slam {

inline Correspondence make_correspondence(const MapPoint& point, const Feature& feature,
                                          const CameraModel& camera, double scale,
                                          const VisualOdometryConfig& config) {
  Correspondence c;
  c.p_reference = point.p_odom;
  c.pixel = {feature.u_px, feature.v_px};
  c.pixel_sigma = config.pixel_sigma * scale;
  c.depth_m = feature.depth_m;
  c.depth_sigma_m = camera.depth_sigma(feature.depth_m);
  return c;
}

}  // namespace fusion_slam
