// VisualOdometry: what happens when a frame becomes a keyframe.
#include <algorithm>

#include "services/visual_odometry/relocaliser.hpp"
#include "services/visual_odometry/visual_odometry.hpp"

namespace fusion_slam {
namespace {

double median_depth(const FeatureSet& set) {
  std::vector<float> depths;
  for (const Feature& f : set.features)
    if (f.depth_m > 0.0F) depths.push_back(f.depth_m);
  if (depths.empty()) return 0.0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

}  // namespace

bool VisualOdometry::wants_keyframe(const PoseEstimate& estimate, const FeatureSet& set) {
  KeyframeEvidence evidence;
  evidence.n_inliers = static_cast<int>(estimate.matched.matches.size());
  if (frames_since_keyframe_ == 1) inliers_at_keyframe_ = evidence.n_inliers;
  if (std::exchange(found_again_, false)) return true;
  evidence.n_inliers_at_keyframe = inliers_at_keyframe_;
  // Surfaces carry the pose: only a new view brings new features.
  if (evidence.n_inliers < config_.min_inliers) evidence.n_inliers_at_keyframe = 0;
  evidence.T_keyframe_camera = T_odom_reference().inverse() * T_odom_camera_;
  evidence.median_depth_m = median_depth(set);
  return decide_keyframe(evidence, config_) != KeyframeReason::kNone;
}

std::vector<SeenLandmark> VisualOdometry::landmarks_in(const PoseEstimate& estimate) const {
  std::vector<SeenLandmark> seen;
  for (const MapMatch& m : estimate.matched.matches)
    seen.push_back({local_[m.point].landmark, m.feature});
  return seen;
}

void VisualOdometry::add_keyframe(std::vector<SeenLandmark> seen, bool connected, FeatureSet set,
                                  TrackingResult* result) {
  if (mapping_.busy() && config_.wait_for_mapping) {
    const std::map<std::int64_t, std::int64_t> became = finish_mapping();
    for (SeenLandmark& s : seen)
      for (auto it = became.find(s.landmark); it != became.end(); it = became.find(s.landmark))
        s.landmark = it->second;
  }
  const SE3 T_camera_base = robot_.T_base_camera.inverse();
  Keyframe keyframe;
  keyframe.id = std::max(newest_ + 1, first_id_);
  keyframe.utime_us = result->utime_us;
  keyframe.T_odom_base = T_odom_camera_ * T_camera_base;
  keyframe.covariance = result->covariance;
  if (connected) {
    keyframe.previous_id = reference_;
    keyframe.T_previous_base =
        robot_.T_base_camera * T_odom_reference().inverse() * T_odom_camera_ * T_camera_base;
    open_.emplace(keyframe.id, reference_);
  }
  const SurfaceTie tie = connected && weak_ ? tie_to_reference() : SurfaceTie{};
  newest_ = reference_ = keyframe.id;
  frames_since_keyframe_ = 0;

  MapKeyframe in_map;
  in_map.id = keyframe.id;
  in_map.utime_us = keyframe.utime_us;
  in_map.segment = segment_;
  in_map.T_odom_camera = T_odom_camera_;
  in_map.features = std::make_shared<const FeatureSet>(set);
  in_map.tie = tie;
  in_map.previous = keyframe.previous_id;
  insert_keyframe(std::move(in_map), camera_, seen, scales_, config_.pixel_sigma, &map_);
  keyframe.landmark_of_feature = map_.keyframe(newest_)->landmark_of_feature;
  keyframe.refined = settled_edges();
  if (mapping_.busy()) {  // this keyframe's turn comes when the thread is done
    ++counts_.mappings_late;
    renew_local_map();
  } else {
    follow_graph();
    start_mapping();
  }
  places_.add(map_, newest_ - config_.trial_keyframes - 1);
  keyframe.features = std::move(set);
  result->keyframe = std::move(keyframe);
}

// Everything that needs the map to itself, before the thread gets its copy for the newest keyframe.
void VisualOdometry::start_mapping() {
  mapped_ = newest_;
  if (n_segments_ > 1) join_segments();
  counts_.keyframes_thinned += thinning_.thin(reference_, config_, &map_);
  renew_local_map();
  if (config_.bundle_keyframes > 0) mapping_.start(make_mapping_job(map_, newest_, config_));
}

// What the surfaces of this frame and of the reference keyframe say of the motion between the two.
SurfaceTie VisualOdometry::tie_to_reference() const {
  SurfaceTie tie;
  if (surfaces_keyframe_ == 0 || surfaces_keyframe_ != reference_) return tie;
  const auto motion = track_surfaces(surfaces_of_keyframe_.view(camera_, config_.surfaces),
                                     T_odom_reference(), now_.view(camera_, config_.surfaces),
                                     T_odom_camera_, camera_, nullptr, config_.surfaces);
  if (!motion) return tie;
  tie.keyframe = reference_;
  tie.T_earlier_camera = T_odom_reference().inverse() * motion->T_odom_camera;
  tie.information = motion->information;
  return tie;
}

// A place of another segment in sight: from now on both are one, as seen from here.
void VisualOdometry::join_segments() {
  const SE3 T_odom_newest = map_.keyframe(newest_)->T_odom_camera;
  const FeatureSet& set = *map_.keyframe(newest_)->features;
  const auto candidates = places_.similar(map_, set, segment_, config_.reloc_candidates);
  const auto found =
      relocalise(map_, candidates, camera_, set, scales_, config_.join_inliers, config_);
  if (!found) return;
  const int other = map_.keyframe(found->keyframe)->segment;
  places_.add_landmarks(
      map_,
      map_.join_segment(other, segment_, T_odom_newest * found->estimate.T_odom_camera.inverse()));
  --n_segments_;
  ++counts_.joins;
}

std::vector<RefinedEdge> VisualOdometry::settled_edges() {
  std::vector<RefinedEdge> settled;
  while (!open_.empty() && open_.begin()->first + config_.settle_keyframes <= newest_) {
    const auto [id, previous] = *open_.begin();
    open_.erase(open_.begin());
    const MapKeyframe* a = map_.keyframe(previous);
    const MapKeyframe* b = map_.keyframe(id);
    if (a == nullptr || b == nullptr) continue;
    settled.push_back({id, robot_.T_base_camera * a->T_odom_camera.inverse() * b->T_odom_camera *
                               robot_.T_base_camera.inverse()});
  }
  return settled;
}

}  // namespace fusion_slam
