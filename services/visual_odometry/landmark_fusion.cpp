#include "services/visual_odometry/landmark_fusion.hpp"

#include <algorithm>

#include "libs/features/pose_refiner.hpp"
#include "services/visual_odometry/correspondences.hpp"
#include "services/visual_odometry/projection_matcher.hpp"

namespace fusion_slam {
namespace {

bool seen_by(const Landmark& landmark, std::int64_t keyframe) {
  return std::any_of(landmark.observations.begin(), landmark.observations.end(),
                     [&](const Observation& o) { return o.keyframe == keyframe; });
}

// Two landmarks that one keyframe sees as two features are two.
bool seen_together(const Landmark& a, const Landmark& b) {
  return std::any_of(a.observations.begin(), a.observations.end(),
                     [&](const Observation& o) { return seen_by(b, o.keyframe); });
}

bool fits(const CameraModel& camera, const Eigen::Vector3d& p_odom, const Feature& f,
          const SE3& T_odom_camera, double pixel_sigma, const VisualOdometryConfig& config) {
  Eigen::Vector3d r;
  return pose_residual(camera, make_correspondence(p_odom, f, pixel_sigma), T_odom_camera, &r,
                       nullptr) &&
         r.squaredNorm() <= (f.depth_m > 0.0F ? config.refine.gate_3d : config.refine.gate_2d);
}

}  // namespace

int fuse_landmarks(const CameraModel& camera, const std::vector<std::int64_t>& wanted,
                   std::int64_t keyframe_id, const std::vector<double>& scale_of_octave,
                   const VisualOdometryConfig& config, VisualMap* map) {
  const MapKeyframe* keyframe = map->keyframe(keyframe_id);
  if (keyframe == nullptr) return 0;
  LocalMap points;
  for (const std::int64_t id : wanted) {
    const Landmark* l = map->landmark(id);
    if (l == nullptr || seen_by(*l, keyframe_id)) continue;
    points.push_back({id, l->p_odom, l->viewed_from, l->reach_m, l->descriptor, l->angle_rad});
  }
  const FeatureSet& set = *keyframe->features;
  const FeatureGrid grid(set.features, camera.width_px, camera.height_px);
  VisualOdometryConfig strict = config;
  strict.max_distance = config.fuse_distance;
  const ProjectionMatches found =
      match_by_projection(points, camera, keyframe->T_odom_camera, set, grid, scale_of_octave,
                          config.fuse_radius_px, strict);
  int n = 0;
  for (const MapMatch& m : found.matches) {
    const std::int64_t id = points[m.point].landmark;
    const Feature& f = set.features[m.feature];
    const Landmark* wanted_one = map->landmark(id);
    if (wanted_one == nullptr) continue;  // merged a moment ago
    if (!fits(camera, wanted_one->p_odom, f, keyframe->T_odom_camera,
              config.pixel_sigma * scale_of_octave[f.octave], config))
      continue;
    const std::int64_t other = keyframe->landmark_of_feature[m.feature];
    if (other == 0) {
      n += map->link(id, keyframe_id, m.feature) ? 1 : 0;
      continue;
    }
    const Landmark* there = map->landmark(other);
    if (there == nullptr || seen_together(*wanted_one, *there)) continue;
    const bool keep_there = there->observations.size() >= wanted_one->observations.size();
    map->merge(keep_there ? id : other, keep_there ? other : id);
    ++n;
  }
  return n;
}

}  // namespace fusion_slam
