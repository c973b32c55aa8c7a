// VisualOdometry: going on where an earlier process ended.
#include <algorithm>

#include "services/visual_odometry/visual_odometry.hpp"

namespace fusion_slam {

// The keyframes' features with depth make the map again; what bundle adjustment and triangulation
// knew better comes back with the next keyframes. The first frame is then tracked or looked for as
// after any gap. Edges that were said stay as they are: they came from the map before, which was
// adjusted; T_odom_base is where each keyframe was believed to be at first.
void VisualOdometry::resume(const std::vector<Keyframe>& keyframes, std::int64_t first_id) {
  if (newest_ != 0) return;
  first_id_ = first_id;
  if (keyframes.empty()) return;
  segment_ = n_segments_ = 1;
  std::map<std::int64_t, std::int64_t> became;  // landmarks: the earlier process's id -> ours
  for (const Keyframe& keyframe : keyframes) {
    std::vector<SeenLandmark> seen;
    for (std::size_t i = 0; i < keyframe.landmark_of_feature.size(); ++i) {
      const auto it = became.find(keyframe.landmark_of_feature[i]);
      if (it != became.end()) seen.push_back({it->second, static_cast<int>(i)});
    }
    MapKeyframe in_map;
    in_map.id = keyframe.id;
    in_map.utime_us = keyframe.utime_us;
    in_map.segment = segment_;
    in_map.T_odom_camera = keyframe.T_odom_base * robot_.T_base_camera;
    in_map.previous = keyframe.previous_id;
    in_map.features = std::make_shared<const FeatureSet>(keyframe.features);
    insert_keyframe(std::move(in_map), camera_, seen, scales_, config_.pixel_sigma, &map_);
    const std::vector<std::int64_t>& ours = map_.keyframe(keyframe.id)->landmark_of_feature;
    for (std::size_t i = 0; i < keyframe.landmark_of_feature.size(); ++i)
      if (keyframe.landmark_of_feature[i] != 0 && ours[i] != 0)
        became.emplace(keyframe.landmark_of_feature[i], ours[i]);
  }
  const Keyframe& last = keyframes.back();
  newest_ = reference_ = mapped_ = last.id;
  for (const auto& [id, keyframe] : map_.keyframes())
    if (id < std::max(newest_, first_id_ - 1) - config_.trial_keyframes) places_.add(map_, id);
  T_odom_camera_ = last.T_odom_base * robot_.T_base_camera;
  motion_.restart(T_odom_camera_);
  last_utime_us_ = pose_utime_us_ = fix_utime_us_ = last.utime_us;
  weak_ = true;
  segment_started_ = resumed_ = true;
  renew_local_map();
}

}  // namespace fusion_slam
