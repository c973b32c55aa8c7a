// Pinhole camera whose depth image is registered to its colour image. Optical frame: x right, y
// down, z forward; metres.
#pragma once

#include <array>

#include <Eigen/Core>

namespace fusion_slam {

struct CameraModel {
  int width_px = 640;
  int height_px = 480;
  double fx_px = 525.0;
  double fy_px = 525.0;
  double cx_px = 319.5;  // pixel centres are at integers
  double cy_px = 239.5;
  std::array<double, 5> distortion{};  // k1, k2, p1, p2, k3 (OpenCV order)
  double depth_min_m = 0.4;
  double depth_max_m = 8.0;
  double depth_sigma_m =
      0.0012;  // sigma(z) = depth_sigma_m + depth_sigma_per_m * z^2: structured-light
  double depth_sigma_per_m =
      0.0019;  // cameras (Khoshelham & Elberink 2012; Nguyen et al. 2012), 1/m
  double rate_hz = 30.0;

  // Pixel of a point in the optical frame, ideal (no distortion). z must not be 0.
  Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const {
    return {fx_px * p_camera.x() / p_camera.z() + cx_px,
            fy_px * p_camera.y() / p_camera.z() + cy_px};
  }
  // Point in the optical frame of an ideal pixel at depth z_m (equation 2 of the paper).
  Eigen::Vector3d unproject(double u_px, double v_px, double z_m) const {
    return {(u_px - cx_px) / fx_px * z_m, (v_px - cy_px) / fy_px * z_m, z_m};
  }
  // Standard deviation of a depth reading at z_m.
  double depth_sigma(double z_m) const { return depth_sigma_m + depth_sigma_per_m * z_m * z_m; }
  bool depth_valid(double z_m) const { return z_m >= depth_min_m && z_m <= depth_max_m; }
  bool has_distortion() const {
    for (const double k : distortion)
      if (k != 0.0) return true;
    return false;
  }
};

}  // namespace fusion_slam
