// Whether a place seen long ago lies where the camera sees it now.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature_grid.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

// Odometry that is pulled onto an old place bends: the drift of a whole round goes into the metre
// in which the place comes into sight, and the edges of these keyframes say so to the pose graph
// with the confidence of a good view. So old places are used where they agree with what is tracked
// (errors no larger than what adjustment takes); where they don't, the loop detector and the pose
// graph spread the error over the round, and graph_revision brings the old place here.

// The landmarks of keyframe `old` are looked for in keyframe `now` within config.wide_radius_px:
// true when at least config.agree_landmarks are found and config.agree_share of these fit the pose
// of `now`. Both of one segment. `grid` holds the features of `now`. Pure.
bool agrees(const VisualMap& map, const MapKeyframe& old, const MapKeyframe& now,
            const FeatureGrid& grid, const CameraModel& camera,
            const std::vector<double>& scale_of_octave, const VisualOdometryConfig& config);

}  // namespace fusion_slam
