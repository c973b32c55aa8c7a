#include "services/visual_odometry/visual_map.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

template <class Map>
auto* find_in(Map& map, std::int64_t id) {
  const auto it = map.find(id);
  return it == map.end() ? nullptr : &it->second;
}

auto place_of(std::vector<Observation>& observations, std::int64_t keyframe) {
  return std::lower_bound(
      observations.begin(), observations.end(), keyframe,
      [](const Observation& o, std::int64_t wanted) { return o.keyframe < wanted; });
}

}  // namespace

const MapKeyframe* VisualMap::keyframe(std::int64_t id) const { return find_in(keyframes_, id); }
MapKeyframe* VisualMap::keyframe(std::int64_t id) { return find_in(keyframes_, id); }
const Landmark* VisualMap::landmark(std::int64_t id) const { return landmarks_.find(id); }
Landmark* VisualMap::landmark(std::int64_t id) { return landmarks_.find(id); }

void VisualMap::add_keyframe(MapKeyframe keyframe) {
  const std::int64_t id = keyframe.id;
  keyframes_.insert_or_assign(id, std::move(keyframe));
}

void VisualMap::erase_keyframe(std::int64_t id) {
  const MapKeyframe* known = keyframe(id);
  if (known == nullptr) return;
  const std::vector<std::int64_t> seen = known->landmark_of_feature;
  for (const std::int64_t landmark : seen)
    if (landmark != 0) unlink(landmark, id);
  keyframes_.erase(id);
}

std::int64_t VisualMap::add_landmark(Landmark landmark) {
  landmarks_.emplace(next_landmark_, std::move(landmark));
  return next_landmark_++;
}

void VisualMap::erase_landmark(std::int64_t id) {
  const Landmark* known = landmark(id);
  if (known == nullptr) return;
  for (const Observation& o : known->observations)
    if (MapKeyframe* seen_by = keyframe(o.keyframe)) seen_by->landmark_of_feature[o.feature] = 0;
  landmarks_.erase(id);
}

bool VisualMap::link(std::int64_t landmark_id, std::int64_t keyframe_id, int feature) {
  Landmark* known = landmark(landmark_id);
  MapKeyframe* by = keyframe(keyframe_id);
  if (known == nullptr || by == nullptr || by->landmark_of_feature[feature] != 0) return false;
  const auto place = place_of(known->observations, keyframe_id);
  if (place != known->observations.end() && place->keyframe == keyframe_id) return false;
  known->observations.insert(place, {keyframe_id, feature});
  by->landmark_of_feature[feature] = landmark_id;
  return true;
}

void VisualMap::unlink(std::int64_t landmark_id, std::int64_t keyframe_id) {
  Landmark* known = landmark(landmark_id);
  if (known == nullptr) return;
  const auto place = place_of(known->observations, keyframe_id);
  if (place == known->observations.end() || place->keyframe != keyframe_id) return;
  if (MapKeyframe* by = keyframe(keyframe_id)) by->landmark_of_feature[place->feature] = 0;
  known->observations.erase(place);
  if (known->observations.empty()) landmarks_.erase(landmark_id);
}

void VisualMap::merge(std::int64_t from_id, std::int64_t to_id) {
  Landmark* from = landmark(from_id);
  Landmark* to = landmark(to_id);
  if (from == nullptr || to == nullptr || from_id == to_id) return;
  for (const Observation& o : from->observations) {
    MapKeyframe* by = keyframe(o.keyframe);
    const auto place = place_of(to->observations, o.keyframe);
    const bool twice = place != to->observations.end() && place->keyframe == o.keyframe;
    if (by != nullptr) by->landmark_of_feature[o.feature] = twice ? 0 : to_id;
    if (!twice) to->observations.insert(place, o);
  }
  to->visible += from->visible;
  to->found += from->found;
  to->information += from->information;
  landmarks_.erase(from_id);
  merged_.emplace_back(from_id, to_id);
}

void renew_look(const FeatureSet& set, int feature, const SE3& T_odom_camera, double scale,
                Landmark* landmark) {
  const Eigen::Vector3d to_camera = T_odom_camera.translation() - landmark->p_odom;
  landmark->viewed_from = to_camera.normalized();
  landmark->reach_m = to_camera.norm() * scale;
  landmark->descriptor = set.descriptors[feature];
  landmark->angle_rad = set.features[feature].angle_rad;
}

}  // namespace fusion_slam
