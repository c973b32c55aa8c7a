#include "services/visual_odometry/local_map.hpp"

#include <algorithm>
#include <set>

#include "services/visual_odometry/place_agreement.hpp"

namespace fusion_slam {

std::vector<std::pair<std::int64_t, int>> covisible_keyframes(const VisualMap& map,
                                                              std::int64_t keyframe) {
  std::vector<std::pair<std::int64_t, int>> result;
  const MapKeyframe* centre = map.keyframe(keyframe);
  if (centre == nullptr) return result;
  std::map<std::int64_t, int> shared;
  for (const std::int64_t id : centre->landmark_of_feature) {
    const Landmark* landmark = id == 0 ? nullptr : map.landmark(id);
    if (landmark == nullptr) continue;
    for (const Observation& o : landmark->observations)
      if (o.keyframe != keyframe) ++shared[o.keyframe];
  }
  result.assign(shared.begin(), shared.end());
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first > b.first;
  });
  return result;
}

std::vector<std::int64_t> local_keyframes(const VisualMap& map, int segment,
                                          const SE3& T_odom_camera, const CameraModel& camera,
                                          const std::vector<double>& scale_of_octave,
                                          const VisualOdometryConfig& config) {
  std::set<std::int64_t> chosen;
  std::vector<std::pair<double, std::int64_t>> near;
  std::int64_t newest = 0;
  for (auto it = map.keyframes().rbegin(); it != map.keyframes().rend(); ++it) {
    const MapKeyframe& keyframe = it->second;
    if (keyframe.segment != segment) continue;
    if (newest == 0) newest = keyframe.id;
    if (static_cast<int>(chosen.size()) < config.local_recent_keyframes) {
      chosen.insert(keyframe.id);
      continue;
    }
    const SE3 between = T_odom_camera.inverse() * keyframe.T_odom_camera;
    const double apart_m = between.translation().norm();
    const double cosine = between.linear()(2, 2);  // of the angle between the optical axes
    if (apart_m > config.local_near_m || cosine < config.local_near_cosine) continue;
    near.emplace_back(apart_m + 2.0 * (1.0 - cosine), keyframe.id);
  }
  int taken = 0;
  for (const auto& [id, shared] : covisible_keyframes(map, newest)) {
    if (shared < config.covisible_landmarks || taken >= config.local_covisible_keyframes) break;
    const MapKeyframe* keyframe = map.keyframe(id);
    if (keyframe != nullptr && keyframe->segment == segment && chosen.insert(id).second) ++taken;
  }
  const MapKeyframe* now = map.keyframe(newest);
  if (near.empty() || now == nullptr) return {chosen.begin(), chosen.end()};
  const FeatureGrid grid(now->features->features, camera.width_px, camera.height_px);
  std::sort(near.begin(), near.end());
  int judged = 0;
  for (const auto& [distance, id] : near) {
    if (chosen.count(id) > 0) continue;
    if (++judged > config.local_near_keyframes) break;
    if (agrees(map, *map.keyframe(id), *now, grid, camera, scale_of_octave, config))
      chosen.insert(id);
  }
  return {chosen.begin(), chosen.end()};
}

LocalMap make_local_map(const VisualMap& map, const std::vector<std::int64_t>& keyframes) {
  std::vector<std::int64_t> ids;
  for (const std::int64_t keyframe : keyframes)
    if (const MapKeyframe* known = map.keyframe(keyframe))
      for (const std::int64_t id : known->landmark_of_feature)
        if (id != 0) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  LocalMap local;
  local.reserve(ids.size());
  for (const std::int64_t id : ids)
    if (const Landmark* l = map.landmark(id))
      local.push_back({id, l->p_odom, l->viewed_from, l->reach_m, l->descriptor, l->angle_rad});
  return local;
}

}  // namespace fusion_slam
