#include "services/loop_detector/loop_detector.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>

#include "libs/features/pose_refiner.hpp"
#include "services/loop_detector/geometry_check.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint32_t kIndexSeed = 20251;  // any; the same in every run

}  // namespace

LoopDetector::LoopDetector(const CameraModel& camera, const SE3& T_base_camera,
                           const LoopDetectorConfig& config)
    : config_(config),
      camera_(camera),
      T_base_camera_(T_base_camera),
      index_(config.index_tables, config.index_key_bits, kIndexSeed) {}

std::vector<LoopCandidate> LoopDetector::add(LoopKeyframe keyframe) {
  if (!keyframes_.empty() && keyframe.id <= keyframes_.rbegin()->first) return {};
  admit(keyframe);
  std::vector<LoopCandidate> candidates;
  for (const Place& place : similar_places(keyframe.features))
    candidates.push_back(examine(place, keyframe));
  const std::int64_t id = keyframe.id;
  waiting_.push_back(id);
  keyframes_.emplace(id, std::move(keyframe));
  return candidates;
}

void LoopDetector::moved(std::int64_t keyframe_id, const SE3& T_map_base) {
  T_map_base_[keyframe_id] = T_map_base;
}

// Keyframes become places when they are old enough, so that the newest never drown the others'
// votes.
void LoopDetector::admit(const LoopKeyframe& newest) {
  while (waiting_.size() >= static_cast<std::size_t>(config_.not_before_keyframes)) {
    const LoopKeyframe& oldest = keyframes_.at(waiting_.front());
    if (newest.utime_us - oldest.utime_us < config_.not_before_us) return;
    for (const Descriptor& d : oldest.features.descriptors)
      index_.add(d, static_cast<int>(oldest.id));
    waiting_.pop_front();
  }
}

// Each feature gives one vote to every place that has one like it.
std::vector<LoopDetector::Place> LoopDetector::similar_places(const FeatureSet& set) const {
  std::map<int, int> votes;
  for (const Descriptor& d : set.descriptors) {
    int last = -1;  // neighbours come in the order they were added: those of a place together
    for (const LshIndex::Near& n : index_.near(d, config_.max_distance)) {
      if (n.label != last) ++votes[n.label];
      last = n.label;
    }
  }
  std::vector<Place> places;
  for (const auto& [id, count] : votes)
    if (count >= config_.min_votes * static_cast<double>(set.size())) places.push_back({id, count});
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.votes > b.votes; });
  if (places.size() > static_cast<std::size_t>(config_.max_candidates))
    places.resize(config_.max_candidates);
  return places;
}

LoopCandidate LoopDetector::examine(const Place& place, const LoopKeyframe& keyframe) const {
  LoopCandidate candidate;
  candidate.from_id = place.id;
  candidate.to_id = keyframe.id;
  candidate.utime_us = keyframe.utime_us;
  candidate.stages.push_back({"appearance",
                              place.votes / static_cast<double>(keyframe.features.size()),
                              config_.min_votes, true, "share of features seen there"});

  const LoopKeyframe& older = keyframes_.at(place.id);
  const GeometryCheck check = check_geometry(camera_, older.features, keyframe.features, config_);
  const double apart_m =
      (T_map_base(older).translation() - T_map_base(keyframe).translation()).norm();
  const bool fits = check.n_inliers >= config_.min_inliers;
  char reason[160];
  std::snprintf(reason, sizeof reason, "%d matches, %d agree on one motion; %.2f m apart so far",
                check.n_matches, check.n_inliers, apart_m);
  candidate.stages.push_back({"geometry", static_cast<double>(check.n_inliers),
                              static_cast<double>(config_.min_inliers), fits, reason});
  if (fits) {
    candidate.T_from_to = T_base_camera_ * check.T_older_newer * T_base_camera_.inverse();
    candidate.covariance = in_base_axes(check.covariance, T_base_camera_);
  }
  candidate.stages.push_back({"lidar", 0.0, 0.0, false, "not run in this version"});
  candidate.stages.push_back({"consistency", 0.0, 0.0, false, "not run in this version"});
  candidate.accepted = fits && config_.accept_without_lidar;
  return candidate;
}

// As the graph has it; where it has not (yet), odometry from the newest keyframe that it has.
SE3 LoopDetector::T_map_base(const LoopKeyframe& keyframe) const {
  const auto known = T_map_base_.upper_bound(keyframe.id);
  if (known == T_map_base_.begin()) return keyframe.T_odom_base;
  const auto& [id, T_map_known] = *std::prev(known);
  if (id == keyframe.id) return T_map_known;
  const auto anchor = keyframes_.find(id);
  if (anchor == keyframes_.end()) return keyframe.T_odom_base;
  return T_map_known * anchor->second.T_odom_base.inverse() * keyframe.T_odom_base;
}

}  // namespace fusion_slam
