// The part of the map that the next frames are tracked against, laid out for fast projection.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

struct TrackPoint {
  std::int64_t landmark = 0;
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();
  Eigen::Vector3d viewed_from = Eigen::Vector3d::Zero();  // unit
  double reach_m = 0.0;                                   // as in Landmark
  Descriptor descriptor{};
  float angle_rad = 0.0F;
};

using LocalMap = std::vector<TrackPoint>;  // ascending in landmark

// Keyframes whose landmarks may be seen from T_odom_camera, ascending: the newest ones, those that
// share most landmarks with the newest (Mur-Artal et al. 2015, section V-D), and those that looked
// at the same place before, however long ago, and agree with the newest (place_agreement.hpp). Of
// one segment. Deterministic.
std::vector<std::int64_t> local_keyframes(const VisualMap& map, int segment,
                                          const SE3& T_odom_camera, const CameraModel& camera,
                                          const std::vector<double>& scale_of_octave,
                                          const VisualOdometryConfig& config);

// The landmarks that these keyframes see.
LocalMap make_local_map(const VisualMap& map, const std::vector<std::int64_t>& keyframes);

// How many landmarks each other keyframe shares with this one, most first; equal ones newest first.
std::vector<std::pair<std::int64_t, int>> covisible_keyframes(const VisualMap& map,
                                                              std::int64_t keyframe);

}  // namespace fusion_slam
