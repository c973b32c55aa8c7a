// What the map forgets (Mur-Artal et al. 2015, sections VI-B and VI-D): landmarks that are hardly
// ever found where they should be or that nobody saw again, keyframes that show nothing of their
// own.
#pragma once

#include <cstdint>
#include <vector>

#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

// Judges all landmarks of the map as of keyframe `newest`. Returns how many went.
int cull_landmarks(std::int64_t newest, const VisualOdometryConfig& config, VisualMap* map);

// Of `candidates`, forgets those of whose landmarks nearly all are seen by three other keyframes of
// the map at the same or a finer scale. One at a time, oldest first, so that copies don't
// all go. Returns how many went.
int cull_keyframes(const std::vector<std::int64_t>& candidates, const VisualOdometryConfig& config,
                   VisualMap* map);

}  // namespace fusion_slam
