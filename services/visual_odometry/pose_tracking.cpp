#include "services/visual_odometry/pose_tracking.hpp"

#include "libs/features/pose_refiner.hpp"
#include "services/visual_odometry/correspondences.hpp"

namespace fusion_slam {
namespace {

PoseEstimate estimate_pose(const LocalMap& map, const CameraModel& camera, const SE3& guess,
                           const FeatureSet& set, const FeatureGrid& grid,
                           const std::vector<double>& scales, double radius_px,
                           const VisualOdometryConfig& config) {
  PoseEstimate estimate;
  estimate.matched = match_by_projection(map, camera, guess, set, grid, scales, radius_px, config);
  std::vector<Correspondence> correspondences;
  correspondences.reserve(estimate.matched.matches.size());
  for (const MapMatch& m : estimate.matched.matches) {
    const Feature& f = set.features[m.feature];
    correspondences.push_back(
        make_correspondence(map[m.point].p_odom, f, config.pixel_sigma * scales[f.octave]));
  }
  const RefinedPose refined = refine_pose(camera, correspondences, guess, config.refine);
  estimate.T_odom_camera = refined.T_reference_camera;
  estimate.covariance = refined.covariance;
  std::vector<MapMatch> inliers;
  for (std::size_t i = 0; i < correspondences.size(); ++i)
    if (refined.inlier[i]) inliers.push_back(estimate.matched.matches[i]);
  estimate.matched.matches = std::move(inliers);
  return estimate;
}

}  // namespace

std::optional<PoseEstimate> track_local_map(const LocalMap& map, const CameraModel& camera,
                                            const SE3& guess_T_odom_camera, const FeatureSet& set,
                                            const std::vector<double>& scale_of_octave,
                                            double radius_px, const VisualOdometryConfig& config) {
  const auto enough = [&](const PoseEstimate& e) {
    return static_cast<int>(e.matched.matches.size()) >= config.min_inliers;
  };
  const FeatureGrid grid(set.features, camera.width_px, camera.height_px);
  const PoseEstimate rough = estimate_pose(map, camera, guess_T_odom_camera, set, grid,
                                           scale_of_octave, radius_px, config);
  if (!enough(rough)) return std::nullopt;
  PoseEstimate fine = estimate_pose(map, camera, rough.T_odom_camera, set, grid, scale_of_octave,
                                    config.narrow_radius_px, config);
  return enough(fine) ? std::make_optional(std::move(fine)) : std::nullopt;
}

PoseEstimate track_from_prior(const LocalMap& map, const CameraModel& camera,
                              const CameraPosePrior& prior, const FeatureSet& set,
                              const std::vector<double>& scale_of_octave,
                              const VisualOdometryConfig& config) {
  VisualOdometryConfig held = config;
  held.refine.prior = prior;
  const FeatureGrid grid(set.features, camera.width_px, camera.height_px);
  return estimate_pose(map, camera, prior.T_reference_camera, set, grid, scale_of_octave,
                       config.narrow_radius_px, held);
}

}  // namespace fusion_slam
