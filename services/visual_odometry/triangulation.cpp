#include "services/visual_odometry/triangulation.hpp"

#include "libs/features/pose_refiner.hpp"
#include "services/visual_odometry/correspondences.hpp"

namespace fusion_slam {
namespace {

struct Bearings {
  std::vector<int> features;
  std::vector<Descriptor> descriptors;
};

Bearings unplaced(const MapKeyframe& keyframe) {
  Bearings result;
  for (std::size_t i = 0; i < keyframe.features->size(); ++i) {
    if (keyframe.landmark_of_feature[i] != 0) continue;
    if (keyframe.features->features[i].depth_m > 0.0F) continue;
    result.features.push_back(static_cast<int>(i));
    result.descriptors.push_back(keyframe.features->descriptors[i]);
  }
  return result;
}

Eigen::Vector3d ray(const CameraModel& camera, const MapKeyframe& keyframe, const Feature& f) {
  return (keyframe.T_odom_camera.linear() * camera.unproject(f.u_px, f.v_px, 1.0)).normalized();
}

bool fits(const CameraModel& camera, const Eigen::Vector3d& p_odom, const MapKeyframe& keyframe,
          const Feature& f, double pixel_sigma, double gate) {
  Eigen::Vector3d r;
  return pose_residual(camera, make_correspondence(p_odom, f, pixel_sigma), keyframe.T_odom_camera,
                       &r, nullptr) &&
         r.squaredNorm() <= gate;
}

}  // namespace

std::optional<Eigen::Vector3d> intersect_rays(const Eigen::Vector3d& origin_a,
                                              const Eigen::Vector3d& direction_a,
                                              const Eigen::Vector3d& origin_b,
                                              const Eigen::Vector3d& direction_b,
                                              double min_parallax_rad) {
  const double cosine = direction_a.dot(direction_b);
  const double sine2 = 1.0 - cosine * cosine;
  if (cosine < 0.0 || sine2 < min_parallax_rad * min_parallax_rad) return std::nullopt;
  const Eigen::Vector3d between = origin_b - origin_a;
  const double along_a = (between.dot(direction_a) - cosine * between.dot(direction_b)) / sine2;
  const double along_b = (cosine * between.dot(direction_a) - between.dot(direction_b)) / sine2;
  if (along_a <= 0.0 || along_b <= 0.0) return std::nullopt;
  return 0.5 * (origin_a + along_a * direction_a + origin_b + along_b * direction_b);
}

int triangulate(const CameraModel& camera, std::int64_t keyframe_id,
                const std::vector<std::int64_t>& others, const std::vector<double>& scale_of_octave,
                const VisualOdometryConfig& config, VisualMap* map) {
  int n = 0;
  for (const std::int64_t other_id : others) {
    const MapKeyframe* a = map->keyframe(other_id);
    const MapKeyframe* b = map->keyframe(keyframe_id);
    if (a == nullptr || b == nullptr || other_id == keyframe_id) continue;
    const Bearings in_a = unplaced(*a);
    const Bearings in_b = unplaced(*b);
    for (const Match& m : match_mutual(in_a.descriptors, in_b.descriptors, config.relocalisation)) {
      const Feature& fa = a->features->features[in_a.features[m.a]];
      const Feature& fb = b->features->features[in_b.features[m.b]];
      const auto p_odom = intersect_rays(a->T_odom_camera.translation(), ray(camera, *a, fa),
                                         b->T_odom_camera.translation(), ray(camera, *b, fb),
                                         config.min_parallax_rad);
      if (!p_odom) continue;
      const double scale_a = scale_of_octave[fa.octave];
      const double scale_b = scale_of_octave[fb.octave];
      const double gate = config.refine.gate_2d;
      if (!fits(camera, *p_odom, *a, fa, config.pixel_sigma * scale_a, gate) ||
          !fits(camera, *p_odom, *b, fb, config.pixel_sigma * scale_b, gate))
        continue;
      Landmark landmark;
      landmark.p_odom = *p_odom;
      landmark.born = keyframe_id;
      renew_look(*b->features, in_b.features[m.b], b->T_odom_camera, scale_b, &landmark);
      const std::int64_t id = map->add_landmark(std::move(landmark));
      map->link(id, other_id, in_a.features[m.a]);
      map->link(id, keyframe_id, in_b.features[m.b]);
      ++n;
    }
  }
  return n;
}

}  // namespace fusion_slam
