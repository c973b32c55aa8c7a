// What KEYFRAME and LIDAR_NODE say of a place, in plain types. Never trusts what it reads. Pure.
#pragma once

#include <optional>
#include <string>

#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "libs/features/feature.hpp"
#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// Nothing, with the reason in `why`: the numbers of features and of descriptor bytes disagree, or a
// feature has an impossible position, depth, angle or octave.
std::optional<FeatureSet> features_from(const keyframe_t& message, std::string* why);

// End points in base, metres. Nothing, with the reason in `why`, when one is not finite.
std::optional<Points> points_from(const lidar_node_t& message, std::string* why);

}  // namespace fusion_slam
