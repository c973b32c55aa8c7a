#include "services/visual_odometry/thinning.hpp"

#include <algorithm>
#include <vector>

namespace fusion_slam {
namespace {

bool shows_the_same(const MapKeyframe& a, const MapKeyframe& b,
                    const VisualOdometryConfig& config) {
  if (a.segment != b.segment) return false;
  const Eigen::Vector3d apart = a.T_odom_camera.translation() - b.T_odom_camera.translation();
  if (apart.squaredNorm() > config.thin_m * config.thin_m) return false;
  return a.T_odom_camera.linear().col(2).dot(b.T_odom_camera.linear().col(2)) >= config.thin_cosine;
}

// The old keyframes that show what this one does, and itself; ascending.
std::vector<std::int64_t> of_its_place(const MapKeyframe& keyframe, std::int64_t last_old,
                                       const VisualOdometryConfig& config, const VisualMap& map) {
  std::vector<std::int64_t> ids;
  for (const auto& [id, other] : map.keyframes()) {
    if (id > last_old) break;
    if (shows_the_same(keyframe, other, config)) ids.push_back(id);
  }
  return ids;
}

}  // namespace

int KeyframeThinning::thin(std::int64_t reference, const VisualOdometryConfig& config,
                           VisualMap* map) {
  if (map->keyframes().empty()) return 0;
  const std::int64_t newest_us = map->keyframes().rbegin()->second.utime_us;
  const std::int64_t newest_id = map->keyframes().rbegin()->first;
  int n = 0;
  for (auto it = map->keyframes().upper_bound(last_old_); it != map->keyframes().end();
       it = map->keyframes().upper_bound(last_old_)) {
    const MapKeyframe& keyframe = it->second;
    if (newest_us - keyframe.utime_us < config.thin_age_us ||
        keyframe.id + config.settle_keyframes >= newest_id)
      break;
    last_old_ = keyframe.id;
    const std::vector<std::int64_t> place = of_its_place(keyframe, last_old_, config, *map);
    const auto n_first = std::count_if(place.begin(), place.end(),
                                       [&](std::int64_t id) { return first_.count(id) > 0; });
    if (n_first < config.thin_older) first_.insert(last_old_);
    for (const std::int64_t id : place)
      if (id != reference && spare(*map->keyframe(id), config, *map)) {
        map->erase_keyframe(id);
        ++n;
      }
  }
  return n;
}

bool KeyframeThinning::spare(const MapKeyframe& keyframe, const VisualOdometryConfig& config,
                             const VisualMap& map) const {
  if (first_.count(keyframe.id) > 0) return false;
  int n_first = 0;
  int n_newer = 0;
  for (const std::int64_t id : of_its_place(keyframe, last_old_, config, map)) {
    n_first += first_.count(id) > 0 ? 1 : 0;
    n_newer += id > keyframe.id ? 1 : 0;
  }
  return n_first >= config.thin_older && n_newer >= config.thin_newer;
}

}  // namespace fusion_slam
