#include "libs/features/rigid_ransac.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

namespace fusion_slam {
namespace {

constexpr double kMinTriangle_m2 = 1e-3;  // twice the area of the smallest useful sample
constexpr double kMaxStretch_m = 0.10;  // two ends of a sample's side may differ by this plus noise

// T_reference_camera from three pairs; nothing when they are no rigid motion of each other.
std::optional<SE3> pose_of_three(const Eigen::Matrix3d& in_camera,
                                 const Eigen::Matrix3d& in_reference) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const double a = (in_camera.col(i) - in_camera.col(j)).norm();
    const double b = (in_reference.col(i) - in_reference.col(j)).norm();
    if (std::abs(a - b) > kMaxStretch_m + 0.05 * std::max(a, b)) return std::nullopt;
  }
  const Eigen::Vector3d side1 = in_camera.col(1) - in_camera.col(0);
  const Eigen::Vector3d side2 = in_camera.col(2) - in_camera.col(0);
  if (side1.cross(side2).norm() < kMinTriangle_m2) return std::nullopt;
  SE3 T = SE3::Identity();
  T.matrix() = Eigen::umeyama(in_camera, in_reference, false);
  return T.matrix().allFinite() ? std::make_optional(T) : std::nullopt;
}

std::vector<int> inliers_of(const CameraModel& camera, const std::vector<Correspondence>& matches,
                            const SE3& T_reference_camera, const RansacConfig& config) {
  const SE3 T_camera_reference = T_reference_camera.inverse();
  std::vector<int> inliers;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Correspondence& m = matches[i];
    const Eigen::Vector3d p_camera = T_camera_reference * m.p_reference;
    if (p_camera.z() < 0.05) continue;
    if ((camera.project(p_camera) - m.pixel).norm() > config.inlier_sigmas * m.pixel_sigma)
      continue;
    if (m.depth_m > 0.0 && std::abs(p_camera.z() - m.depth_m) >
                               config.depth_sigmas * m.depth_sigma_m + 0.02 * m.depth_m)
      continue;
    inliers.push_back(static_cast<int>(i));
  }
  return inliers;
}

// Samples needed to meet one without outliers with this confidence.
double samples_needed(double inlier_fraction, double confidence) {
  const double good = inlier_fraction * inlier_fraction * inlier_fraction;
  if (good >= 1.0) return 1.0;
  return std::log(1.0 - confidence) / std::log(1.0 - good);
}

}  // namespace

std::optional<RansacResult> find_pose(const CameraModel& camera,
                                      const std::vector<Correspondence>& matches,
                                      const RansacConfig& config) {
  std::vector<int> with_depth;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (matches[i].depth_m > 0.0) with_depth.push_back(static_cast<int>(i));
  if (with_depth.size() < 3) return std::nullopt;

  std::mt19937 random(config.seed);
  RansacResult best;
  double needed = config.max_iterations;
  for (int iteration = 0; iteration < config.max_iterations && iteration < needed; ++iteration) {
    Eigen::Matrix3d in_camera;
    Eigen::Matrix3d in_reference;
    for (int k = 0; k < 3; ++k) {
      const Correspondence& m = matches[with_depth[random() % with_depth.size()]];
      in_camera.col(k) = camera.unproject(m.pixel.x(), m.pixel.y(), m.depth_m);
      in_reference.col(k) = m.p_reference;
    }
    const std::optional<SE3> pose = pose_of_three(in_camera, in_reference);
    if (!pose) continue;
    std::vector<int> inliers = inliers_of(camera, matches, *pose, config);
    if (inliers.size() <= best.inliers.size()) continue;
    best = {*pose, std::move(inliers)};
    needed = samples_needed(static_cast<double>(best.inliers.size()) / matches.size(),
                            config.confidence);
  }
  if (best.inliers.size() < static_cast<std::size_t>(config.min_inliers)) return std::nullopt;
  return best;
}

}  // namespace fusion_slam
