#include "libs/camera/depth_registration.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace fusion_slam {
namespace {

// Plates of one slanted surface part by a fraction of a pixel as parallax grows along it; this
// overlap closes the seams.
constexpr double kOverlapPx = 0.10;

// Rays of a row or column's pixel borders: border i is between pixel i-1 and i.
std::vector<double> border_rays(int n, double f_px, double c_px) {
  std::vector<double> rays;
  for (int i = 0; i <= n; ++i) rays.push_back((i - 0.5 - c_px) / f_px);
  return rays;
}

struct PixelBox {
  int u0, u1, v0, v1;  // inclusive
};

// Integer pixel centres between two projected corners.
PixelBox centres_between(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const CameraModel& c) {
  const Eigen::Vector2d low = a.cwiseMin(b).array() - kOverlapPx;
  const Eigen::Vector2d high = a.cwiseMax(b).array() + kOverlapPx;
  const auto clamp = [](double v, int size) {
    return static_cast<int>(std::clamp(v, -1.0, static_cast<double>(size)));
  };
  return {std::max(0, clamp(std::ceil(low.x()), c.width_px)),
          std::min(c.width_px - 1, clamp(std::floor(high.x()), c.width_px)),
          std::max(0, clamp(std::ceil(low.y()), c.height_px)),
          std::min(c.height_px - 1, clamp(std::floor(high.y()), c.height_px))};
}

}  // namespace

cv::Mat register_depth(const cv::Mat& depth_mm, const DepthRegistration& registration) {
  const CameraModel& from = registration.depth_camera;
  const CameraModel& to = registration.colour_camera;
  if (depth_mm.type() != CV_16UC1 || depth_mm.cols != from.width_px ||
      depth_mm.rows != from.height_px)
    throw std::invalid_argument("register_depth: the image is not the depth camera's");
  const std::vector<double> ray_x = border_rays(from.width_px, from.fx_px, from.cx_px);
  const std::vector<double> ray_y = border_rays(from.height_px, from.fy_px, from.cy_px);
  const SE3& T = registration.T_colour_depth;
  cv::Mat result(to.height_px, to.width_px, CV_16UC1, cv::Scalar(0));
  for (int v = 0; v < depth_mm.rows; ++v) {
    const auto* row = depth_mm.ptr<std::uint16_t>(v);
    for (int u = 0; u < depth_mm.cols; ++u) {
      if (row[u] == 0) continue;
      const double z = 0.001 * row[u];
      const auto i = static_cast<std::size_t>(u);
      const auto j = static_cast<std::size_t>(v);
      const Eigen::Vector3d low = T * Eigen::Vector3d(ray_x[i] * z, ray_y[j] * z, z);
      const Eigen::Vector3d high = T * Eigen::Vector3d(ray_x[i + 1] * z, ray_y[j + 1] * z, z);
      const double z_mm = 500.0 * (low.z() + high.z());  // of the plate's middle
      if (low.z() <= 0.0 || high.z() <= 0.0 || z_mm < 0.5 || z_mm > 65535.0) continue;
      const auto value = static_cast<std::uint16_t>(std::lround(z_mm));
      const PixelBox box = centres_between(to.project(low), to.project(high), to);
      for (int y = box.v0; y <= box.v1; ++y) {
        auto* out = result.ptr<std::uint16_t>(y);
        for (int x = box.u0; x <= box.u1; ++x)
          if (out[x] == 0 || value < out[x]) out[x] = value;
      }
    }
  }
  return result;
}

}  // namespace fusion_slam
