#include "services/visual_odometry/place_agreement.hpp"

#include "libs/features/pose_refiner.hpp"
#include "services/visual_odometry/correspondences.hpp"
#include "services/visual_odometry/local_map.hpp"
#include "services/visual_odometry/projection_matcher.hpp"

namespace fusion_slam {

bool agrees(const VisualMap& map, const MapKeyframe& old, const MapKeyframe& now,
            const FeatureGrid& grid, const CameraModel& camera,
            const std::vector<double>& scale_of_octave, const VisualOdometryConfig& config) {
  const LocalMap place = make_local_map(map, {old.id});
  const FeatureSet& set = *now.features;
  const ProjectionMatches found = match_by_projection(
      place, camera, now.T_odom_camera, set, grid, scale_of_octave, config.wide_radius_px, config);
  const int n = static_cast<int>(found.matches.size());
  if (n < config.agree_landmarks) return false;
  int n_fit = 0;
  for (const MapMatch& m : found.matches) {
    const Feature& f = set.features[m.feature];
    const double gate = f.depth_m > 0.0F ? config.bundle_outlier_3d : config.bundle_outlier_2d;
    Eigen::Vector3d residual;
    if (pose_residual(camera,
                      make_correspondence(place[m.point].p_odom, f,
                                          config.pixel_sigma * scale_of_octave[f.octave]),
                      now.T_odom_camera, &residual, nullptr) &&
        residual.squaredNorm() <= gate)
      ++n_fit;
  }
  return n_fit >= config.agree_share * n;
}

}  // namespace fusion_slam
