#include "services/visual_odometry/landmark_creation.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace fusion_slam {

Eigen::Matrix3d observation_information(const CameraModel& camera, const SE3& T_odom_camera,
                                        const Eigen::Vector3d& p_camera, double pixel_sigma_px,
                                        double depth_sigma_m) {
  const Eigen::Vector3d ray = p_camera / p_camera.z();
  const double across = pixel_sigma_px / camera.fx_px * p_camera.z();
  Eigen::Matrix3d covariance = depth_sigma_m * depth_sigma_m * ray * ray.transpose();
  covariance(0, 0) += across * across;
  covariance(1, 1) += across * across;
  const Eigen::Matrix3d R = T_odom_camera.linear();
  return R * covariance.inverse() * R.transpose();
}

std::vector<std::int64_t> insert_keyframe(MapKeyframe keyframe, const CameraModel& camera,
                                          const std::vector<SeenLandmark>& seen,
                                          const std::vector<double>& scale_of_octave,
                                          double pixel_sigma, VisualMap* map) {
  const std::int64_t id = keyframe.id;
  const SE3 T_odom_camera = keyframe.T_odom_camera;
  const std::shared_ptr<const FeatureSet> set = keyframe.features;
  keyframe.landmark_of_feature.assign(set->size(), 0);
  map->add_keyframe(std::move(keyframe));
  const auto measure = [&](int feature, Landmark* landmark) {
    const Feature& f = set->features[feature];
    if (f.depth_m <= 0.0F) return;
    const Eigen::Vector3d p_camera = camera.unproject(f.u_px, f.v_px, f.depth_m);
    const Eigen::Matrix3d gained = observation_information(
        camera, T_odom_camera, p_camera, pixel_sigma * scale_of_octave[f.octave], f.depth_sigma_m);
    const Eigen::Matrix3d total = landmark->information + gained;
    landmark->p_odom = total.ldlt().solve(landmark->information * landmark->p_odom +
                                          gained * (T_odom_camera * p_camera));
    landmark->information = total;
  };
  const auto look = [&](int feature, Landmark* landmark) {
    renew_look(*set, feature, T_odom_camera, scale_of_octave[set->features[feature].octave],
               landmark);
  };
  for (const SeenLandmark& s : seen)
    if (map->link(s.landmark, id, s.feature)) {
      measure(s.feature, map->landmark(s.landmark));
      look(s.feature, map->landmark(s.landmark));
    }

  std::vector<std::int64_t> made;
  const std::vector<std::int64_t>& taken = map->keyframe(id)->landmark_of_feature;
  for (std::size_t i = 0; i < set->size(); ++i) {
    const Feature& f = set->features[i];
    if (taken[i] != 0 || f.depth_m <= 0.0F) continue;
    Landmark landmark;
    measure(static_cast<int>(i), &landmark);
    landmark.born = id;
    look(static_cast<int>(i), &landmark);
    made.push_back(map->add_landmark(std::move(landmark)));
    map->link(made.back(), id, static_cast<int>(i));
  }
  return made;
}

}  // namespace fusion_slam
