#include "services/visual_odometry/surface_tracking.hpp"

#include <cmath>

#include <Eigen/Cholesky>

namespace fusion_slam {
namespace {

// Mean depth of 5 x 5 pixels, or 0 where fewer than half are valid or an edge runs through.
double smooth_depth(const cv::Mat& depth_mm, const CameraModel& camera, int u, int v) {
  double sum = 0.0;
  double low = 1e9;
  double high = 0.0;
  int n = 0;
  for (int y = v - 2; y <= v + 2; ++y)
    for (int x = u - 2; x <= u + 2; ++x) {
      const double z = depth_mm.at<std::uint16_t>(y, x) * 1e-3;
      if (!camera.depth_valid(z)) continue;
      sum += z;
      low = std::min(low, z);
      high = std::max(high, z);
      ++n;
    }
  if (n < 13) return 0.0;
  const double mean = sum / n;
  return high - low > 0.04 * mean + 8.0 * camera.depth_sigma(mean) ? 0.0 : mean;
}

// Normals of small patches are noisy, and noise in a normal makes sliding along the surface look
// measured: each becomes the mean of those around it that lie on the same surface.
void smooth_normals(const SurfaceConfig& config, SurfaceView* view) {
  const std::vector<SurfaceSample> raw = view->samples;
  const int reach = config.smooth_samples;
  for (int row = 0; row < view->rows; ++row)
    for (int column = 0; column < view->columns; ++column) {
      const int at = row * view->columns + column;
      if (raw[at].point.z() <= 0.0) continue;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int y = std::max(0, row - reach); y <= std::min(view->rows - 1, row + reach); ++y)
        for (int x = std::max(0, column - reach); x <= std::min(view->columns - 1, column + reach);
             ++x) {
          const SurfaceSample& other = raw[y * view->columns + x];
          if (other.point.z() <= 0.0 || other.normal.dot(raw[at].normal) < config.gate_cosine ||
              std::abs(raw[at].normal.dot(other.point - raw[at].point)) > config.gate_m)
            continue;
          sum += other.normal;
        }
      view->samples[at].normal = sum.normalized();
    }
}

struct Sums {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  int n_seen = 0;   // samples that fall onto one of the other view
  int n_pairs = 0;  // of these: on the same surface
};

Sums sum_up(const SurfaceView& before, const SurfaceView& now, const SE3& T_before_now,
            const CameraModel& camera, const SurfaceConfig& config) {
  Sums sums;
  for (const SurfaceSample& s : now.samples) {
    if (s.point.z() <= 0.0) continue;
    const Eigen::Vector3d p = T_before_now * s.point;
    if (p.z() < camera.depth_min_m) continue;
    const Eigen::Vector2d pixel = camera.project(p) / config.step_px;
    const int column = static_cast<int>(std::lround(pixel.x())) - 1;
    const int row = static_cast<int>(std::lround(pixel.y())) - 1;
    if (column < 0 || row < 0 || column >= before.columns || row >= before.rows) continue;
    const SurfaceSample& other = before.samples[row * before.columns + column];
    if (other.point.z() <= 0.0) continue;
    ++sums.n_seen;
    const Eigen::Vector3d normal = T_before_now.linear().transpose() * other.normal;  // axes of now
    const double r = other.normal.dot(p - other.point);
    if (std::abs(r) > config.gate_m || normal.dot(s.normal) < config.gate_cosine) continue;
    ++sums.n_pairs;
    Vector6d J;
    J << normal, s.point.cross(normal);
    const double sigma = config.noise_factor * camera.depth_sigma(s.point.z());
    sums.H.noalias() += J * J.transpose() / (sigma * sigma);
    sums.b.noalias() += J * r / (sigma * sigma);
  }
  return sums;
}

}  // namespace

SurfaceView see_surfaces(const cv::Mat& depth_mm, const CameraModel& camera,
                         const SurfaceConfig& config) {
  const int step = config.step_px;
  const int half = step / 2;
  SurfaceView view;
  view.columns = std::max(0, depth_mm.cols / step - 1);
  view.rows = std::max(0, depth_mm.rows / step - 1);
  view.samples.resize(static_cast<std::size_t>(view.columns) * view.rows);
  const auto point_at = [&](int u, int v) -> Eigen::Vector3d {
    const double z = smooth_depth(depth_mm, camera, u, v);
    return z > 0.0 ? camera.unproject(u, v, z) : Eigen::Vector3d::Zero();
  };
  // Sample (row, column) lies at pixel ((column + 1) step, (row + 1) step); its corners are shared
  // with its neighbours.
  std::vector<Eigen::Vector3d> corners;
  for (int row = 0; row <= view.rows; ++row)
    for (int column = 0; column <= view.columns; ++column)
      corners.push_back(point_at(column * step + half, row * step + half));
  for (int row = 0; row < view.rows; ++row)
    for (int column = 0; column < view.columns; ++column) {
      const int at = row * (view.columns + 1) + column;
      const Eigen::Vector3d& a = corners[at];
      const Eigen::Vector3d& b = corners[at + 1];
      const Eigen::Vector3d& c = corners[at + view.columns + 1];
      const Eigen::Vector3d& d = corners[at + view.columns + 2];
      if (a.z() <= 0.0 || b.z() <= 0.0 || c.z() <= 0.0 || d.z() <= 0.0) continue;
      const Eigen::Vector3d mean = 0.25 * (a + b + c + d);
      const double spread =
          (Eigen::Vector4d(a.z(), b.z(), c.z(), d.z()).array() - mean.z()).abs().maxCoeff();
      if (spread > 0.05 * mean.z() + 4.0 * camera.depth_sigma(mean.z())) continue;  // an edge
      Eigen::Vector3d normal = (d - a).cross(c - b).normalized();
      if (!normal.allFinite()) continue;
      if (normal.dot(mean) > 0.0) normal = -normal;
      view.samples[static_cast<std::size_t>(row) * view.columns + column] = {mean, normal};
    }
  smooth_normals(config, &view);
  return view;
}

std::optional<SurfaceMotion> track_surfaces(const SurfaceView& before, const SE3& T_odom_before,
                                            const SurfaceView& now, const SE3& guess_T_odom_camera,
                                            const CameraModel& camera, const PlanarPrior* planar,
                                            const SurfaceConfig& config) {
  Vector6d prior = Vector6d::Constant(1.0 / (config.prior_sigma_m * config.prior_sigma_m));
  prior.tail<3>().setConstant(1.0 / (config.prior_sigma_rad * config.prior_sigma_rad));
  SurfaceMotion motion;
  motion.T_odom_camera = guess_T_odom_camera;
  for (int i = 0; i <= config.iterations; ++i) {
    Sums sums = sum_up(before, now, T_odom_before.inverse() * motion.T_odom_camera, camera, config);
    motion.n_pairs = sums.n_pairs;
    if (sums.n_pairs < config.min_pairs || sums.n_pairs < config.min_share * sums.n_seen)
      return std::nullopt;
    motion.information = sums.H;
    sums.H.diagonal() += prior;
    sums.b += prior.cwiseProduct(local(guess_T_odom_camera, motion.T_odom_camera));
    if (planar != nullptr) {
      PlanarJacobian J;
      const Eigen::Vector3d r = planar_prior_residual(*planar, motion.T_odom_camera, &J);
      sums.H += J.transpose() * J;
      sums.b += J.transpose() * r;
    }
    const Eigen::LDLT<Matrix6d> ldlt(sums.H);
    motion.covariance = ldlt.solve(Matrix6d::Identity());
    const Vector6d step = ldlt.solve(-sums.b);
    if (!step.allFinite() || !motion.covariance.allFinite()) return std::nullopt;
    if (i == config.iterations || step.norm() < 1e-6) break;
    motion.T_odom_camera = retract(motion.T_odom_camera, step);
  }
  return motion;
}

}  // namespace fusion_slam
