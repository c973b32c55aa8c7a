#include "libs/features/feature_depth.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <opencv2/calib3d.hpp>

namespace fusion_slam {
namespace {

constexpr int kMinValid = 4;
constexpr double kEdgeSigmas = 6.0;  // range of 9 readings: about 3 sigma of noise
constexpr double kEdgeSlope = 0.01;  // and a surface seen at 75 degrees: 2 px * z / f * tan

}  // namespace

double depth_at(const cv::Mat& depth_mm, const CameraModel& camera, double u_px, double v_px) {
  const int u = cvRound(u_px);
  const int v = cvRound(v_px);
  std::array<double, 9> valid{};
  int n = 0;
  for (int y = std::max(0, v - 1); y <= std::min(depth_mm.rows - 1, v + 1); ++y)
    for (int x = std::max(0, u - 1); x <= std::min(depth_mm.cols - 1, u + 1); ++x) {
      const double z_m = depth_mm.at<std::uint16_t>(y, x) * 1e-3;
      if (camera.depth_valid(z_m)) valid[n++] = z_m;
    }
  if (n < kMinValid) return 0.0;
  std::sort(valid.begin(), valid.begin() + n);
  const double median = valid[n / 2];
  const double spread = valid[n - 1] - valid[0];
  return spread > kEdgeSigmas * camera.depth_sigma(median) + kEdgeSlope * median ? 0.0 : median;
}

void attach_depth(const cv::Mat& depth_mm, const CameraModel& camera, FeatureSet* set) {
  for (Feature& f : set->features) {
    f.depth_m = static_cast<float>(depth_at(depth_mm, camera, f.u_px, f.v_px));
    f.depth_sigma_m = f.depth_m > 0.0F ? static_cast<float>(camera.depth_sigma(f.depth_m)) : 0.0F;
  }
}

void undistort(const CameraModel& camera, FeatureSet* set) {
  if (!camera.has_distortion() || set->empty()) return;
  const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
  const cv::Mat distortion(1, 5, CV_64F, const_cast<double*>(camera.distortion.data()));
  std::vector<cv::Point2d> pixels;
  for (const Feature& f : set->features) pixels.emplace_back(f.u_px, f.v_px);
  std::vector<cv::Point2d> ideal;
  cv::undistortPoints(pixels, ideal, K, distortion, cv::noArray(), K);
  for (std::size_t i = 0; i < ideal.size(); ++i) {
    set->features[i].u_px = static_cast<float>(ideal[i].x);
    set->features[i].v_px = static_cast<float>(ideal[i].y);
  }
}

}  // namespace fusion_slam
