#include "services/visual_odometry/graph_revision.hpp"

namespace fusion_slam {

void GraphRevision::update(std::int64_t keyframe, const SE3& T_map_base) {
  said_[keyframe] = T_map_base;
  news_ = news_ || taken_.count(keyframe) > 0;
}

void GraphRevision::forget(std::int64_t keyframe) {
  said_.erase(keyframe);
  taken_.erase(keyframe);
}

// Keyframes that local mapping has culled. What is known of them is asked for nowhere.
void GraphRevision::forget_gone(const VisualMap& map) {
  if (said_.size() <= 2 * map.keyframes().size() + 64) return;
  for (auto it = said_.begin(); it != said_.end();) {
    const std::int64_t id = (it++)->first;
    if (map.keyframe(id) == nullptr) forget(id);
  }
}

Revised GraphRevision::take_up(std::int64_t reference, const SE3& T_base_camera,
                               const VisualOdometryConfig& config, VisualMap* map) {
  forget_gone(*map);
  if (!news_) {
    taken_.insert(said_.begin(), said_.end());
    return {};
  }
  news_ = false;
  Revised revised;
  // Newer keyframes hang on this one: it is what stays where it is.
  auto here = taken_.upper_bound(reference);
  const MapKeyframe* anchor = nullptr;
  while (anchor == nullptr && here != taken_.begin()) anchor = map->keyframe((--here)->first);
  std::map<std::int64_t, SE3> T_new_old;
  if (anchor != nullptr) {
    const SE3 T_here_map = said_.at(anchor->id).inverse();
    const SE3 T_odom_map = anchor->T_odom_camera * T_base_camera.inverse() * T_here_map;
    for (const auto& [id, before] : taken_) {
      MapKeyframe* keyframe = map->keyframe(id);
      if (keyframe == nullptr || id + config.settle_keyframes >= reference) continue;
      const Vector6d change = local(here->second.inverse() * before, T_here_map * said_.at(id));
      if (change.head<3>().norm() < config.revision_m &&
          change.tail<3>().norm() < config.revision_rad)
        continue;
      const SE3 T_odom_camera = T_odom_map * said_.at(id) * T_base_camera;
      T_new_old.emplace(id, T_odom_camera * keyframe->T_odom_camera.inverse());
      keyframe->T_odom_camera = T_odom_camera;
    }
  }
  if (T_new_old.empty()) {
    taken_.insert(said_.begin(), said_.end());
  } else {
    revised.landmarks = map->carry_landmarks(T_new_old);
    taken_ = said_;
    map->untie(T_new_old);
  }
  for (const auto& [id, T] : T_new_old) revised.keyframes.push_back(id);
  return revised;
}

}  // namespace fusion_slam
