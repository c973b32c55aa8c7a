// Camera pose from matches of which many may be wrong, without a guess.
// Sources: Fischler & Bolles 1981 (RANSAC); Horn 1987 / Umeyama 1991 (pose from three 3D-3D pairs,
// since an RGB-D camera measures both ends); the score is the reprojection, as in
// perspective-n-point (Lepetit et al. 2009).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/correspondence.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct RansacConfig {
  int max_iterations = 500;
  double confidence = 0.999;   // stop when a better sample is this unlikely
  double inlier_sigmas = 3.0;  // reprojection, in units of pixel_sigma
  double depth_sigmas = 4.0;   // and depth, in units of depth_sigma_m plus 2 % of the depth
  int min_inliers = 12;
  std::uint32_t seed = 1;  // same matches, same answer
};

struct RansacResult {
  SE3 T_reference_camera = SE3::Identity();
  std::vector<int> inliers;  // indices into the matches, ascending
};

// Nothing when no pose has min_inliers. Matches without depth don't make samples but count as
// inliers.
std::optional<RansacResult> find_pose(const CameraModel& camera,
                                      const std::vector<Correspondence>& matches,
                                      const RansacConfig& config = {});

}  // namespace fusion_slam
