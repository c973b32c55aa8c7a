// Random points in front of a camera and what it measures of them, for the tests of pose
// estimation.
#pragma once

#include <random>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/correspondence.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// n matches; every third has no depth. Noise as the correspondence claims it (times noise); `wrong`
// of them, the first ones, look somewhere else.
inline std::vector<Correspondence> made_up_matches(const CameraModel& camera,
                                                   const SE3& T_reference_camera, int n, int wrong,
                                                   double noise, std::mt19937* random) {
  std::uniform_real_distribution<double> u(0.0, 1.0);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<Correspondence> matches;
  for (int i = 0; i < n; ++i) {
    const double z_m = 0.8 + 3.0 * u(*random);
    const Eigen::Vector2d pixel(camera.width_px * u(*random), camera.height_px * u(*random));
    Correspondence c;
    c.p_reference = T_reference_camera * camera.unproject(pixel.x(), pixel.y(), z_m);
    c.pixel_sigma = 0.7;
    c.depth_sigma_m = camera.depth_sigma(z_m);
    c.pixel = pixel + noise * c.pixel_sigma * Eigen::Vector2d(normal(*random), normal(*random));
    c.depth_m = i % 3 == 0 ? 0.0 : z_m + noise * c.depth_sigma_m * normal(*random);
    if (i < wrong) c.pixel = {camera.width_px * u(*random), camera.height_px * u(*random)};
    matches.push_back(c);
  }
  return matches;
}

}  // namespace fusion_slam
