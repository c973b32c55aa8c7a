#include "services/visual_odometry/local_map.hpp"

#include <algorithm>

#include <Eigen/LU>

namespace fusion_slam {
namespace {

constexpr int kTrialFrames = 15;  // a point is judged after it should have been seen this often
constexpr double kMinFoundRatio = 0.25;  // Mur-Artal et al. 2015, section VI-B

}  // namespace

Eigen::Matrix3d observation_information(const CameraModel& camera, const SE3& T_odom_camera,
                                        const Eigen::Vector3d& p_camera, double pixel_sigma_px) {
  // Along the ray the depth's noise, across it the pixel's.
  const Eigen::Vector3d ray = p_camera / p_camera.z();
  const double across = pixel_sigma_px / camera.fx_px * p_camera.z();
  const double along = camera.depth_sigma(p_camera.z());
  Eigen::Matrix3d covariance = along * along * ray * ray.transpose();
  covariance(0, 0) += across * across;
  covariance(1, 1) += across * across;
  const Eigen::Matrix3d R = T_odom_camera.linear();
  return R * covariance.inverse() * R.transpose();
}

void LocalMap::clear() {
  points_.clear();
  keyframes_.clear();
}

void LocalMap::add_keyframe(std::int64_t id, const CameraModel& camera, const SE3& T_odom_camera,
                            const FeatureSet& set, const std::vector<double>& scale_of_octave,
                            double pixel_sigma, int keep,
                            std::vector<std::int64_t>* point_of_feature) {
  for (std::size_t i = 0; i < set.size(); ++i) {
    const Feature& f = set.features[i];
    auto known = points_.find((*point_of_feature)[i]);
    if (known == points_.end() && f.depth_m <= 0.0F) continue;
    if (known == points_.end()) known = points_.emplace(next_point_++, MapPoint{}).first;
    (*point_of_feature)[i] = known->first;
    MapPoint& point = known->second;
    const double scale = scale_of_octave[f.octave];
    if (f.depth_m > 0.0F) {
      const Eigen::Vector3d p_camera = camera.unproject(f.u_px, f.v_px, f.depth_m);
      const Eigen::Matrix3d gained =
          observation_information(camera, T_odom_camera, p_camera, pixel_sigma * scale);
      const Eigen::Matrix3d total = point.information + gained;
      point.p_odom = total.ldlt().solve(point.information * point.p_odom +
                                        gained * (T_odom_camera * p_camera));
      point.information = total;
    }
    const Eigen::Vector3d to_camera = T_odom_camera.translation() - point.p_odom;
    point.viewed_from = to_camera.normalized();
    point.reach_m = to_camera.norm() * scale;
    point.descriptor = set.descriptors[i];
    point.angle_rad = f.angle_rad;
    point.last_keyframe = id;
  }
  keyframes_.push_back(id);
  while (keyframes_.size() > static_cast<std::size_t>(keep)) keyframes_.pop_front();
  for (auto it = points_.begin(); it != points_.end();) {
    const MapPoint& point = it->second;
    const bool old = point.last_keyframe < keyframes_.front();
    const bool poor = point.visible >= kTrialFrames && point.found < kMinFoundRatio * point.visible;
    it = old || poor ? points_.erase(it) : std::next(it);
  }
}

}  // namespace fusion_slam
