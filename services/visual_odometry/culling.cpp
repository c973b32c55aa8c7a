#include "services/visual_odometry/culling.hpp"

namespace fusion_slam {
namespace {

// Other keyframes of the map that see the landmark at most one octave coarser.
int fine_views(const VisualMap& map, const Landmark& landmark, std::int64_t keyframe, int octave) {
  int n = 0;
  for (const Observation& o : landmark.observations) {
    const MapKeyframe* other = o.keyframe == keyframe ? nullptr : map.keyframe(o.keyframe);
    if (other != nullptr && other->features->features[o.feature].octave <= octave + 1) ++n;
  }
  return n;
}

bool redundant(const VisualMap& map, const MapKeyframe& keyframe,
               const VisualOdometryConfig& config) {
  int n = 0;
  int n_well_seen = 0;
  for (std::size_t i = 0; i < keyframe.landmark_of_feature.size(); ++i) {
    const std::int64_t id = keyframe.landmark_of_feature[i];
    const Landmark* landmark = id == 0 ? nullptr : map.landmark(id);
    if (landmark == nullptr || keyframe.features->features[i].depth_m <= 0.0F) continue;
    ++n;
    const Feature& feature = keyframe.features->features[i];
    if (fine_views(map, *landmark, keyframe.id, feature.octave) >= config.redundant_views)
      ++n_well_seen;
  }
  return n_well_seen > config.redundant_share * n;
}

}  // namespace

int cull_landmarks(std::int64_t newest, const VisualOdometryConfig& config, VisualMap* map) {
  std::vector<std::int64_t> going;
  for (const auto& [id, landmark] : map->landmarks()) {
    const bool tried = landmark.visible >= config.trial_frames;
    const bool poor = tried && landmark.found < config.min_found_ratio * landmark.visible;
    const bool alone = landmark.observations.size() < 2 && landmark.found < config.trial_found &&
                       landmark.born + config.trial_keyframes <= newest;
    if (poor || alone) going.push_back(id);
  }
  for (const std::int64_t id : going) map->erase_landmark(id);
  return static_cast<int>(going.size());
}

int cull_keyframes(const std::vector<std::int64_t>& candidates, const VisualOdometryConfig& config,
                   VisualMap* map) {
  int n = 0;
  for (const std::int64_t id : candidates) {
    const MapKeyframe* keyframe = map->keyframe(id);
    if (keyframe == nullptr || !redundant(*map, *keyframe, config)) continue;
    map->erase_keyframe(id);
    ++n;
  }
  return n;
}

}  // namespace fusion_slam
