// VisualMap: keyframes are moved by what lies outside it (the pose graph, another segment).
#include <set>

#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {
namespace {

// A landmark that lies so far, as seen from a keyframe, from where the keyframe would have it, is
// torn off: about 3 pixels.
constexpr double kTear_rad = 0.005;

}  // namespace

void VisualMap::carry_landmark(std::int64_t id, const std::map<std::int64_t, SE3>& T_new_old,
                               std::vector<std::int64_t>* copies) {
  Landmark& landmark = landmarks_.at(id);
  const auto moved = [&](std::int64_t keyframe) {
    const auto T = T_new_old.find(keyframe);
    return T == T_new_old.end() ? SE3::Identity() : T->second;
  };
  const SE3 T = moved(landmark.observations.back().keyframe);
  const Eigen::Vector3d p_odom = T * landmark.p_odom;
  std::vector<Observation> going_along, torn;
  for (const Observation& o : landmark.observations) {
    const MapKeyframe* by = keyframe(o.keyframe);
    const Eigen::Vector3d p_for_it = moved(o.keyframe) * landmark.p_odom;
    const bool fits =
        by == nullptr || (p_for_it - p_odom).norm() <=
                             kTear_rad * (p_for_it - by->T_odom_camera.translation()).norm();
    (fits ? going_along : torn).push_back(o);
  }
  if (!torn.empty()) {
    Landmark copy = landmark;
    const double share = static_cast<double>(torn.size()) / landmark.observations.size();
    copy.information *= share;
    landmark.information *= 1.0 - share;
    landmark.observations = going_along;
    copy.observations = torn;
    const MapKeyframe& by = *keyframe(torn.back().keyframe);
    copy.descriptor = by.features->descriptors[torn.back().feature];
    copy.angle_rad = by.features->features[torn.back().feature].angle_rad;
    const SE3 T_old_odom = moved(by.id).inverse();
    copy.viewed_from = (T_old_odom * by.T_odom_camera.translation() - copy.p_odom).normalized();
    copies->push_back(add_landmark(std::move(copy)));
    for (const Observation& o : torn)
      keyframe(o.keyframe)->landmark_of_feature[o.feature] = copies->back();
    carry_landmark(copies->back(), T_new_old, copies);
  }
  landmark.p_odom = p_odom;
  landmark.viewed_from = T.linear() * landmark.viewed_from;
  landmark.information = T.linear() * landmark.information * T.linear().transpose();
}

std::vector<std::int64_t> VisualMap::carry_landmarks(const std::map<std::int64_t, SE3>& T_new_old) {
  std::set<std::int64_t> seen;
  for (const auto& [id, T] : T_new_old)
    if (const MapKeyframe* known = keyframe(id))
      seen.insert(known->landmark_of_feature.begin(), known->landmark_of_feature.end());
  seen.erase(0);
  std::vector<std::int64_t> copies;
  for (const std::int64_t id : seen) carry_landmark(id, T_new_old, &copies);
  return copies;
}

void VisualMap::untie(const std::map<std::int64_t, SE3>& moved) {
  for (auto& [id, keyframe] : keyframes_)
    if (moved.count(id) != moved.count(keyframe.tie.keyframe)) keyframe.tie = {};
}

std::vector<std::int64_t> VisualMap::join_segment(int from, int to, const SE3& T_to_from) {
  std::map<std::int64_t, SE3> moved;
  for (auto& [id, keyframe] : keyframes_) {
    if (keyframe.segment != from) continue;
    keyframe.segment = to;
    keyframe.T_odom_camera = T_to_from * keyframe.T_odom_camera;
    moved.emplace(id, T_to_from);
  }
  return carry_landmarks(moved);
}

}  // namespace fusion_slam
