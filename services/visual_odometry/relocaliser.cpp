#include "services/visual_odometry/relocaliser.hpp"

#include "services/visual_odometry/correspondences.hpp"

namespace fusion_slam {

std::optional<SE3> relocalise(const LocalMap& map, const CameraModel& camera, const FeatureSet& set,
                              const std::vector<double>& scale_of_octave,
                              const VisualOdometryConfig& config) {
  std::vector<const MapPoint*> points;
  std::vector<Descriptor> descriptors;
  std::vector<float> point_angles;
  for (const auto& [id, point] : map.points()) {
    points.push_back(&point);
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
        make_correspondence(*points[m.a], f, camera, scale_of_octave[f.octave], config));
  }
  const std::optional<RansacResult> found = find_pose(camera, correspondences, config.ransac);
  if (!found) return std::nullopt;
  std::vector<Correspondence> agreed;
  for (const int i : found->inliers) agreed.push_back(correspondences[i]);
  const RefinedPose refined = refine_pose(camera, agreed, found->T_reference_camera, config.refine);
  if (refined.n_inliers < config.ransac.min_inliers) return std::nullopt;
  return refined.T_reference_camera;
}

}  // namespace fusion_slam
