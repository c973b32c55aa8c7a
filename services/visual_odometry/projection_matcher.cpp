#include "services/visual_odometry/projection_matcher.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr double kMaxTurnCosine = 0.5;  // 60 degrees: beyond, a patch no longer looks alike

struct Best {
  int feature = -1;
  int distance = 257;
  int second = 257;
};

}  // namespace

bool other_depth(const Feature& feature, const CameraModel& camera, double z_m) {
  return feature.depth_m > 0.0F &&
         std::abs(feature.depth_m - z_m) > 0.08 * z_m + 4.0 * camera.depth_sigma(z_m);
}

ProjectionMatches match_by_projection(const LocalMap& map, const CameraModel& camera,
                                      const SE3& guess_T_odom_camera, const FeatureSet& set,
                                      const FeatureGrid& grid,
                                      const std::vector<double>& scale_of_octave, double radius_px,
                                      const VisualOdometryConfig& config) {
  const SE3 T_camera_odom = guess_T_odom_camera.inverse();
  const double log_step = std::log(config.orb.scale_factor);
  const int top = static_cast<int>(scale_of_octave.size()) - 1;
  ProjectionMatches result;
  std::vector<MapMatch> of_feature(set.size(), MapMatch{0, -1, 257});
  std::vector<int> nearby;
  for (std::size_t k = 0; k < map.size(); ++k) {
    const TrackPoint& point = map[k];
    const int id = static_cast<int>(k);
    const Eigen::Vector3d p_camera = T_camera_odom * point.p_odom;
    if (p_camera.z() < 0.5 * camera.depth_min_m) continue;
    const Eigen::Vector2d pixel = camera.project(p_camera);
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > camera.width_px - 1 ||
        pixel.y() > camera.height_px - 1)
      continue;
    const Eigen::Vector3d to_camera = guess_T_odom_camera.translation() - point.p_odom;
    if (to_camera.normalized().dot(point.viewed_from) < kMaxTurnCosine) continue;
    result.in_view.push_back(id);

    const double octave = std::log(point.reach_m / to_camera.norm()) / log_step;
    const int near_octave = std::clamp(static_cast<int>(std::lround(octave)), 0, top);
    const int octave_min = static_cast<int>(std::ceil(octave - config.octave_tolerance));
    const int octave_max = static_cast<int>(std::floor(octave + config.octave_tolerance));
    grid.near(pixel.x(), pixel.y(), radius_px * scale_of_octave[near_octave], octave_min,
              octave_max, &nearby);
    Best best;
    for (const int i : nearby) {
      if (other_depth(set.features[i], camera, p_camera.z())) continue;
      const int distance = hamming(point.descriptor, set.descriptors[i]);
      if (distance < best.distance) {
        best.second = best.distance;
        best.distance = distance;
        best.feature = i;
      } else if (distance < best.second) {
        best.second = distance;
      }
    }
    if (best.feature < 0 || best.distance > config.max_distance) continue;
    if (best.second <= 256 && best.distance > config.ratio * best.second) continue;
    MapMatch& taken = of_feature[best.feature];
    if (best.distance < taken.distance) taken = {id, best.feature, best.distance};
  }
  for (const MapMatch& match : of_feature)
    if (match.feature >= 0) result.matches.push_back(match);
  return result;
}

}  // namespace fusion_slam
