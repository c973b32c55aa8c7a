#include "services/dense_mapper/depth_cloud.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>

namespace fusion_slam {
namespace {

constexpr int kSurfaceStridePx = 16;
constexpr int kSurfaceReachPx =
    8;  // normals over 17 px: 20 cm at 4 m, wide enough for the depth's steps

class DepthImage {
 public:
  DepthImage(const cv::Mat& depth_mm, const CameraModel& camera, double max_m)
      : depth_mm_(depth_mm), min_m_(camera.depth_min_m), max_m_(max_m) {}

  // 0: no depth there, or outside the image.
  double raw_m(int u, int v) const {
    if (u < 0 || v < 0 || u >= depth_mm_.cols || v >= depth_mm_.rows) return 0.0;
    return depth_mm_.at<std::uint16_t>(v, u) * 1e-3;
  }
  // 0 also outside the trusted range.
  double trusted_m(int u, int v) const {
    const double z_m = raw_m(u, v);
    return z_m >= min_m_ && z_m <= max_m_ ? z_m : 0.0;
  }

 private:
  const cv::Mat& depth_mm_;
  double min_m_;
  double max_m_;
};

// Inverse depth of five pixels in a row, 0 where there is none.
using Row = std::array<double, 5>;

Row inverse_along(const DepthImage& depth, int u, int v, int du, int dv) {
  Row inverse{};
  for (int i = 0; i < 5; ++i) {
    const double z_m = depth.raw_m(u + (i - 2) * du, v + (i - 2) * dv);
    inverse[static_cast<std::size_t>(i)] = z_m > 0.0 ? 1.0 / z_m : 0.0;
  }
  return inverse;
}

// Inverse depth is linear over any plane, however steep: its second difference is zero there, and
// large at an edge, at a flying pixel and one step beside either. A pixel without neighbours on the
// same surface is an outlier.
bool smooth(const Row& inverse, double limit_per_m) {
  if (inverse[1] == 0.0 || inverse[3] == 0.0) return false;  // beside a hole
  for (std::size_t i = 0; i < 3; ++i) {
    if (inverse[i] == 0.0 || inverse[i + 2] == 0.0) continue;
    if (std::abs(inverse[i] - 2.0 * inverse[i + 1] + inverse[i + 2]) > limit_per_m) return false;
  }
  return true;
}

// Cosine of the angle between ray and surface normal. On a plane n . p = d inverse depth is
// (n_x X + n_y Y + n_z) / d with X, Y the ray at z = 1: its gradient is the normal.
double incidence(const Row& along_u, const Row& along_v, const Eigen::Vector3d& ray,
                 const CameraModel& camera, int step_px) {
  const double gx = (along_u[3] - along_u[1]) * camera.fx_px / (2.0 * step_px);
  const double gy = (along_v[3] - along_v[1]) * camera.fy_px / (2.0 * step_px);
  const Eigen::Vector3d normal(gx, gy, along_u[2] - gx * ray.x() - gy * ray.y());
  return along_u[2] / (normal.norm() * ray.norm());
}

// Rays of the sampled pixels at z = 1, distortion removed. Index: column, then row.
class Rays {
 public:
  Rays(const CameraModel& camera, int stride_px) : camera_(camera), stride_px_(stride_px) {
    if (!camera.has_distortion()) return;
    std::vector<cv::Point2d> pixels;
    for (int v = 0; v < camera.height_px; v += stride_px)
      for (int u = 0; u < camera.width_px; u += stride_px) pixels.emplace_back(u, v);
    const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
    const std::vector<double> distortion(camera.distortion.begin(), camera.distortion.end());
    cv::undistortPoints(pixels, undistorted_, K, distortion);
    columns_ = (camera.width_px + stride_px - 1) / stride_px;
  }
  Eigen::Vector3d at(int u, int v) const {
    if (undistorted_.empty()) return camera_.unproject(u, v, 1.0);
    const cv::Point2d& p =
        undistorted_[static_cast<std::size_t>(v / stride_px_) * static_cast<std::size_t>(columns_) +
                     static_cast<std::size_t>(u / stride_px_)];
    return {p.x, p.y, 1.0};
  }

 private:
  const CameraModel& camera_;
  int stride_px_;
  int columns_ = 0;
  std::vector<cv::Point2d> undistorted_;
};

// Normals from central differences of the trusted depth.
void add_surface(const DepthImage& depth, const CameraModel& camera, int u, int v,
                 std::vector<SurfacePoint>* surfaces) {
  const int reach = kSurfaceReachPx;
  const double z_m = depth.trusted_m(u, v);
  std::array<Eigen::Vector3d, 4> around;
  const std::array<std::array<int, 2>, 4> steps{{{reach, 0}, {-reach, 0}, {0, reach}, {0, -reach}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const int uu = u + steps[i][0];
    const int vv = v + steps[i][1];
    const double z = depth.trusted_m(uu, vv);
    if (z == 0.0) return;
    around[i] = camera.unproject(uu, vv, z);
  }
  const Eigen::Vector3d p = camera.unproject(u, v, z_m);
  const double bend =
      std::max(((around[0] + around[1]) / 2 - p).norm(), ((around[2] + around[3]) / 2 - p).norm());
  if (bend > 3.0 * camera.depth_sigma(z_m)) return;  // not flat
  Eigen::Vector3d normal = (around[0] - around[1]).cross(around[2] - around[3]);
  if (normal.norm() == 0.0) return;
  normal.normalize();
  if (normal.dot(p) > 0.0) normal = -normal;
  if (-normal.dot(p.normalized()) < 0.1) return;  // grazing: the normal is noise
  surfaces->push_back({p.cast<float>(), normal.cast<float>()});
}

}  // namespace

double trusted_depth_m(const CameraModel& camera, double resolution_m) {
  if (camera.depth_sigma_per_m <= 0.0) return camera.depth_max_m;
  const double sigma_budget_m = std::max(resolution_m - camera.depth_sigma_m, 0.1 * resolution_m);
  return std::min(camera.depth_max_m, std::sqrt(sigma_budget_m / camera.depth_sigma_per_m));
}

DepthCloud make_depth_cloud(const RgbdFrame& frame, const CameraModel& camera, double resolution_m,
                            const DenseMapperConfig& config) {
  DepthCloud cloud;
  cloud.utime_us = frame.utime_us;
  const DepthImage depth(frame.depth_mm, camera, trusted_depth_m(camera, resolution_m));
  const Rays rays(camera, config.stride_px);
  const int step = config.edge_step_px;
  for (int v = 0; v < frame.depth_mm.rows; v += config.stride_px) {
    for (int u = 0; u < frame.depth_mm.cols; u += config.stride_px) {
      const double z_m = depth.trusted_m(u, v);
      if (z_m == 0.0) continue;
      // Sigma of 1/z is sigma / z^2; of the second difference sqrt(1 + 4 + 1) times that.
      const double limit_per_m =
          config.edge_sigmas * std::sqrt(6.0) * camera.depth_sigma(z_m) / (z_m * z_m);
      const Row along_u = inverse_along(depth, u, v, step, 0);
      const Row along_v = inverse_along(depth, u, v, 0, step);
      if (!smooth(along_u, limit_per_m) || !smooth(along_v, limit_per_m)) continue;
      const Eigen::Vector3d ray = rays.at(u, v);
      if (incidence(along_u, along_v, ray, camera, step) < config.grazing_cosine) continue;
      ColouredPoint point;
      point.p_m = (ray * z_m).cast<float>();
      const auto& bgr = frame.colour_bgr.at<cv::Vec3b>(v, u);
      point.r = bgr[2];
      point.g = bgr[1];
      point.b = bgr[0];
      if (u % (2 * config.stride_px) == 0 && v % (2 * config.stride_px) == 0)
        cloud.sparse.push_back(static_cast<std::uint32_t>(cloud.points.size()));
      cloud.points.push_back(point);
      if (u % kSurfaceStridePx == 0 && v % kSurfaceStridePx == 0)
        add_surface(depth, camera, u, v, &cloud.surfaces);
    }
  }
  return cloud;
}

}  // namespace fusion_slam
