// Landmarks from bearings alone: features beyond the depth camera's range, or without a return,
// get a place in space as soon as two keyframes see them from far enough apart.
// Sources: Hartley & Sturm 1997 (mid-point and its error); Mur-Artal et al. 2015, section VI-C.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

// The point (m, odom) nearest to two rays (origins in odom, directions unit, odom); nothing when
// they are nearly parallel (less than min_parallax_rad) or meet behind an origin.
std::optional<Eigen::Vector3d> intersect_rays(const Eigen::Vector3d& origin_a,
                                              const Eigen::Vector3d& direction_a,
                                              const Eigen::Vector3d& origin_b,
                                              const Eigen::Vector3d& direction_b,
                                              double min_parallax_rad);

// Matches the bearing-only features of `keyframe` that have no landmark with those of each of
// `others` (mutually nearest descriptors), and makes a landmark of each pair whose rays meet
// within the noise. Returns how many.
int triangulate(const CameraModel& camera, std::int64_t keyframe,
                const std::vector<std::int64_t>& others, const std::vector<double>& scale_of_octave,
                const VisualOdometryConfig& config, VisualMap* map);

}  // namespace fusion_slam
