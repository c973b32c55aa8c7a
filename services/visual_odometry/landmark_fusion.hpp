// Landmarks that were made twice become one: what several keyframes saw separately is looked for
// in each other (Mur-Artal et al. 2015, section VI-C, and 2017).
#pragma once

#include <cstdint>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

// Looks for each landmark in `wanted` among the keyframe's features, where it should appear: a
// feature without a landmark is linked to it; one that shows another landmark at the same place in
// space makes the two one (the one seen more often stays). Returns how many links and merges.
int fuse_landmarks(const CameraModel& camera, const std::vector<std::int64_t>& wanted,
                   std::int64_t keyframe, const std::vector<double>& scale_of_octave,
                   const VisualOdometryConfig& config, VisualMap* map);

}  // namespace fusion_slam
