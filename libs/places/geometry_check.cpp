#include "libs/places/geometry_check.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "libs/features/correspondence.hpp"
#include "libs/features/feature_grid.hpp"

namespace fusion_slam {
namespace {

Correspondence correspond(const CameraModel& camera, const Feature& older, const Feature& newer,
                          const GeometryConfig& config) {
  Correspondence c;
  c.p_reference = camera.unproject(older.u_px, older.v_px, older.depth_m);
  c.pixel = {newer.u_px, newer.v_px};
  c.pixel_sigma = config.pixel_sigma * std::pow(config.scale_factor, newer.octave);
  c.depth_m = newer.depth_m;
  // Both ends are measured.
  c.depth_sigma_m =
      std::hypot(camera.depth_sigma(newer.depth_m), camera.depth_sigma(older.depth_m));
  return c;
}

std::vector<Correspondence> by_descriptor(const CameraModel& camera, const FeatureSet& older,
                                          const FeatureSet& newer, const GeometryConfig& config) {
  std::vector<float> angles_older;
  std::vector<float> angles_newer;
  for (const Feature& f : older.features) angles_older.push_back(f.angle_rad);
  for (const Feature& f : newer.features) angles_newer.push_back(f.angle_rad);
  std::vector<Correspondence> result;
  for (const Match& m :
       keep_common_rotation(match_mutual(older.descriptors, newer.descriptors, config.matching),
                            angles_older, angles_newer))
    if (older.features[m.a].depth_m > 0.0F)
      result.push_back(correspond(camera, older.features[m.a], newer.features[m.b], config));
  return result;
}

struct GuidedMatches {
  std::vector<Correspondence> matches;
  std::vector<std::pair<int, int>> features;  // (older, newer), one a match
};

// Each older feature with depth is looked for where the pose puts it; kept are pairs that are each
// other's best.
GuidedMatches guided(const CameraModel& camera, const FeatureSet& older, const FeatureSet& newer,
                     const SE3& T_older_newer, double radius_px, const GeometryConfig& config) {
  const FeatureGrid grid(newer.features, camera.width_px, camera.height_px);
  const SE3 T_newer_older = T_older_newer.inverse();
  const Match none{-1, -1, config.matching.max_distance + 1};
  std::vector<Match> of_older(older.size(), none), of_newer(newer.size(), none);
  std::vector<int> nearby;
  for (std::size_t i = 0; i < older.size(); ++i) {
    const Feature& f = older.features[i];
    if (f.depth_m <= 0.0F) continue;
    const Eigen::Vector3d p_older = camera.unproject(f.u_px, f.v_px, f.depth_m);
    const Eigen::Vector3d p = T_newer_older * p_older;
    if (p.z() < 0.1) continue;
    const Eigen::Vector2d pixel = camera.project(p);
    // What is nearer now looks larger: it is found on a higher octave.
    const double octave =
        f.octave + std::log(p_older.norm() / p.norm()) / std::log(config.scale_factor);
    grid.near(pixel.x(), pixel.y(), radius_px * std::pow(config.scale_factor, f.octave),
              static_cast<int>(std::ceil(octave - config.guided_octaves)),
              static_cast<int>(std::floor(octave + config.guided_octaves)), &nearby);
    for (const int j : nearby) {
      const Match m{static_cast<int>(i), j, hamming(older.descriptors[i], newer.descriptors[j])};
      if (m.distance < of_older[i].distance) of_older[i] = m;
      if (m.distance < of_newer[j].distance) of_newer[j] = m;
    }
  }
  GuidedMatches result;
  for (const Match& m : of_newer) {
    if (m.a < 0 || of_older[m.a].b != m.b) continue;
    result.matches.push_back(correspond(camera, older.features[m.a], newer.features[m.b], config));
    result.features.emplace_back(m.a, m.b);
  }
  return result;
}

double worst_sigma(const Eigen::Matrix3d& covariance) {
  const double most =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .maxCoeff();
  return std::sqrt(std::max(0.0, most));
}

}  // namespace

GeometryCheck check_geometry(const CameraModel& camera, const FeatureSet& older,
                             const FeatureSet& newer, const GeometryConfig& config) {
  GeometryCheck result;
  const std::vector<Correspondence> matches = by_descriptor(camera, older, newer, config);
  result.n_matches = static_cast<int>(matches.size());
  const auto found = find_pose(camera, matches, config.ransac);
  if (!found) return result;
  std::vector<Correspondence> agreed;
  for (const int i : found->inliers) agreed.push_back(matches[i]);
  const RefinedPose rough = refine_pose(camera, agreed, found->T_reference_camera, config.refine);
  GuidedMatches again;
  RefinedPose fine = rough;
  for (const double radius_px : {config.guided_radius_px, 0.5 * config.guided_radius_px}) {
    again = guided(camera, older, newer, fine.T_reference_camera, radius_px, config);
    fine = refine_pose(camera, again.matches, fine.T_reference_camera, config.refine);
  }
  result.n_inliers = fine.n_inliers;
  result.T_older_newer = fine.T_reference_camera;
  result.covariance = fine.covariance;
  const double factor = std::sqrt(config.optimism);
  result.sigma_m = factor * worst_sigma(fine.covariance.topLeftCorner<3, 3>());
  result.sigma_rad = factor * worst_sigma(fine.covariance.bottomRightCorner<3, 3>());
  for (std::size_t i = 0; i < again.features.size(); ++i)
    if (fine.inlier[i]) result.same.push_back(again.features[i]);
  return result;
}

}  // namespace fusion_slam
