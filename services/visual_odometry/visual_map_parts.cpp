// VisualMap: a part of it is copied, improved elsewhere, and put back.
#include <algorithm>
#include <iterator>

#include "libs/geometry/orthonormal.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

VisualMap VisualMap::copy_part(const std::vector<std::int64_t>& ids,
                               const std::vector<std::int64_t>& seen_by) const {
  VisualMap part;
  part.next_landmark_ = next_landmark_;
  part.newest_at_copy_ = keyframes_.empty() ? 0 : keyframes_.rbegin()->first;
  for (const std::int64_t id : ids)
    if (const MapKeyframe* known = keyframe(id)) part.keyframes_.emplace(id, *known);
  for (const std::int64_t id : seen_by)
    if (const MapKeyframe* known = keyframe(id))
      for (const std::int64_t seen : known->landmark_of_feature)
        if (seen != 0) part.landmarks_.emplace(seen, landmarks_.at(seen));
  return part;
}

// Keyframes that came after the copy hang on it, by one another: they go where it goes.
void VisualMap::move_newer(const VisualMap& before, const VisualMap& after) {
  std::map<std::int64_t, SE3> T_new_old;
  for (const auto& [id, was] : before.keyframes_)
    if (const MapKeyframe* now = after.keyframe(id))
      T_new_old.emplace(id, now->T_odom_camera * was.T_odom_camera.inverse());
  for (auto it = keyframes_.upper_bound(before.newest_at_copy_); it != keyframes_.end(); ++it) {
    MapKeyframe& newer = it->second;
    const auto hangs_on = T_new_old.find(newer.previous);
    if (hangs_on == T_new_old.end()) continue;
    const SE3 T = hangs_on->second;
    newer.T_odom_camera = orthonormal(T * newer.T_odom_camera);
    T_new_old.emplace(newer.id, T);
    for (const std::int64_t id : newer.landmark_of_feature) {
      Landmark* own = id < before.next_landmark_ ? nullptr : landmark(id);
      if (own == nullptr || own->observations.front().keyframe != newer.id) continue;
      own->p_odom = T * own->p_odom;
      own->viewed_from = T.linear() * own->viewed_from;
    }
  }
}

void VisualMap::put_back(const VisualMap& before, const VisualMap& after) {
  const std::int64_t newest = before.newest_at_copy_;
  // The part gave its new landmarks ids that may have been given here meanwhile.
  const std::int64_t shift = next_landmark_ - before.next_landmark_;
  const auto id_here = [&](std::int64_t id) {
    return id < before.next_landmark_ ? id : id + shift;
  };
  move_newer(before, after);
  for (const auto& [from, to] : after.merged_) merge(id_here(from), id_here(to));
  for (const auto& [id, was] : before.landmarks_)
    if (after.landmark(id) == nullptr) erase_landmark(id);
  for (const auto& [id, was] : before.keyframes_)
    if (after.keyframe(id) == nullptr) erase_keyframe(id);
  for (const auto& [id, now] : after.keyframes_) {
    MapKeyframe& here = keyframes_.insert_or_assign(id, now).first->second;
    for (std::int64_t& seen : here.landmark_of_feature) seen = id_here(seen);
  }
  for (const auto& [id, now] : after.landmarks_) {
    Landmark& here = landmarks_[id_here(id)];
    Landmark improved = now;
    improved.visible = std::max(here.visible, now.visible);
    improved.found = std::max(here.found, now.found);
    std::copy_if(here.observations.begin(), here.observations.end(),
                 std::back_inserter(improved.observations),
                 [&](const Observation& o) { return o.keyframe > newest; });
    if (!here.observations.empty() && here.observations.back().keyframe > newest) {
      improved.viewed_from = here.viewed_from;
      improved.reach_m = here.reach_m;
      improved.descriptor = here.descriptor;
      improved.angle_rad = here.angle_rad;
    }
    here = std::move(improved);
  }
  next_landmark_ = std::max(next_landmark_, id_here(after.next_landmark_));
  merged_.clear();
}

}  // namespace fusion_slam
