// A map directory as localisation reads it.
#pragma once

#include "libs/localization/localization_map.hpp"
#include "libs/map_directory/map_reader.hpp"

namespace fusion_slam {

// The LiDAR's grid and the keyframes' views, placed where the saved graph has them. Throws
// std::runtime_error, for people, when the map holds neither.
LocalizationMap load_localization_map(const MapReader& reader, const MapState& state,
                                      const LocalizerConfig& config = {});

}  // namespace fusion_slam
