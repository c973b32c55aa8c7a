#include "services/visual_odometry/relocaliser.hpp"

#include "services/visual_odometry/correspondences.hpp"

namespace fusion_slam {
namespace {

// The pose that the landmarks of one keyframe explain best.
std::optional<SE3> pose_from(const LocalMap& points, const CameraModel& camera,
                             const FeatureSet& set, const std::vector<double>& scales,
                             const VisualOdometryConfig& config) {
  std::vector<Descriptor> descriptors;
  std::vector<float> point_angles;
  for (const TrackPoint& point : points) {
    descriptors.push_back(point.descriptor);
    point_angles.push_back(point.angle_rad);
  }
  std::vector<float> feature_angles;
  for (const Feature& f : set.features) feature_angles.push_back(f.angle_rad);
  const std::vector<Match> matches =
      keep_common_rotation(match_mutual(descriptors, set.descriptors, config.relocalisation),
                           point_angles, feature_angles);
  std::vector<Correspondence> correspondences;
  for (const Match& m : matches) {
    const Feature& f = set.features[m.b];
    correspondences.push_back(
        make_correspondence(points[m.a].p_odom, f, config.pixel_sigma * scales[f.octave]));
  }
  const std::optional<RansacResult> found = find_pose(camera, correspondences, config.ransac);
  if (!found) return std::nullopt;
  std::vector<Correspondence> agreed;
  for (const int i : found->inliers) agreed.push_back(correspondences[i]);
  const RefinedPose refined = refine_pose(camera, agreed, found->T_reference_camera, config.refine);
  if (refined.n_inliers < config.ransac.min_inliers) return std::nullopt;
  return refined.T_reference_camera;
}

}  // namespace

std::optional<Relocalised> relocalise(const VisualMap& map,
                                      const std::vector<std::int64_t>& candidates,
                                      const CameraModel& camera, const FeatureSet& set,
                                      const std::vector<double>& scale_of_octave, int min_inliers,
                                      const VisualOdometryConfig& config) {
  for (const std::int64_t candidate : candidates) {
    const LocalMap place = make_local_map(map, {candidate});
    const auto pose = pose_from(place, camera, set, scale_of_octave, config);
    if (!pose) continue;
    std::vector<std::int64_t> around{candidate};
    for (const auto& [id, shared] : covisible_keyframes(map, candidate)) {
      if (static_cast<int>(around.size()) > config.local_covisible_keyframes) break;
      around.push_back(id);
    }
    Relocalised result;
    result.keyframe = candidate;
    result.local = make_local_map(map, around);
    auto estimate = track_local_map(result.local, camera, *pose, set, scale_of_octave,
                                    config.narrow_radius_px, config);
    if (!estimate || static_cast<int>(estimate->matched.matches.size()) < min_inliers) continue;
    result.estimate = std::move(*estimate);
    return result;
  }
  return std::nullopt;
}

}  // namespace fusion_slam
