// A small camera and what is fast with it.
#pragma once

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/config.hpp"

namespace fusion_slam {

constexpr std::int64_t kFrame_us = 33'333;

inline CameraModel small_camera() {
  CameraModel camera;
  camera.width_px = 200;
  camera.height_px = 150;
  camera.fx_px = camera.fy_px = 165.0;
  camera.cx_px = 99.5;
  camera.cy_px = 74.5;
  return camera;
}

inline VisualOdometryConfig small_config() {
  VisualOdometryConfig config;
  config.orb.n_features = 150;
  config.orb.n_levels = 4;
  return config;
}

}  // namespace fusion_slam
