#include "libs/calibration/depth_rays.hpp"

#include <array>
#include <cmath>

#include <opencv2/calib3d.hpp>

namespace fusion_slam {
namespace {

constexpr int kStride_px = 4;
constexpr int kReach_px = 2;
constexpr double kSigmas = 3.0;

double inverse(const cv::Mat& depth_mm, int u, int v) {
  const int mm = depth_mm.at<std::uint16_t>(v, u);
  return mm == 0 ? 0.0 : 1e3 / mm;
}

bool smooth(const cv::Mat& depth_mm, int u, int v, int du, int dv, double limit) {
  const double before = inverse(depth_mm, u - du, v - dv);
  const double after = inverse(depth_mm, u + du, v + dv);
  return before > 0.0 && after > 0.0 &&
         std::abs(before - 2.0 * inverse(depth_mm, u, v) + after) < limit;
}

}  // namespace

DepthSampler::DepthSampler(const CameraModel& camera) : camera_(camera) {
  std::vector<cv::Point2d> pixels;
  for (int u = kStride_px; u < camera.width_px - kStride_px; u += kStride_px)
    for (int v = kStride_px; v < camera.height_px - kStride_px; v += kStride_px)
      pixels.emplace_back(u, v);
  if (camera.has_distortion()) {
    const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
    const std::vector<double> distortion(camera.distortion.begin(), camera.distortion.end());
    cv::undistortPoints(pixels, rays_, K, distortion);
    return;
  }
  for (const cv::Point2d& p : pixels) {
    const Eigen::Vector3d ray = camera.unproject(p.x, p.y, 1.0);
    rays_.emplace_back(ray.x(), ray.y());
  }
}

DepthFrame DepthSampler::sample(std::int64_t utime_us, const cv::Mat& depth_mm) const {
  DepthFrame frame;
  frame.utime_us = utime_us;
  if (depth_mm.type() != CV_16UC1 || depth_mm.cols != camera_.width_px ||
      depth_mm.rows != camera_.height_px)
    return frame;
  std::size_t i = 0;
  for (int u = kStride_px; u < camera_.width_px - kStride_px; u += kStride_px) {
    frame.columns.emplace_back();
    for (int v = kStride_px; v < camera_.height_px - kStride_px; v += kStride_px, ++i) {
      const double w = inverse(depth_mm, u, v);
      if (w == 0.0 || !camera_.depth_valid(1.0 / w)) continue;
      const double limit = kSigmas * std::sqrt(6.0) * camera_.depth_sigma(1.0 / w) * w * w;
      if (!smooth(depth_mm, u, v, kReach_px, 0, limit) ||
          !smooth(depth_mm, u, v, 0, kReach_px, limit))
        continue;
      frame.columns.back().push_back(
          {static_cast<float>(rays_[i].x), static_cast<float>(rays_[i].y), static_cast<float>(w)});
    }
  }
  return frame;
}

}  // namespace fusion_slam
