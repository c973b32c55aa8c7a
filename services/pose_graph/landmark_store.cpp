#include "services/pose_graph/landmark_store.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

// Landmarks that are one (union by the smaller id, paths halved).
class Merged {
 public:
  std::int64_t root(std::int64_t id) {
    for (auto it = parent_.find(id); it != parent_.end(); it = parent_.find(id)) {
      const auto next = parent_.find(it->second);
      if (next != parent_.end()) it->second = next->second;
      id = it->second;
    }
    return id;
  }
  void join(std::int64_t a, std::int64_t b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::map<std::int64_t, std::int64_t> parent_;
};

Track thinned(const Track& track, int most) {
  const auto n = track.size();
  const auto m = static_cast<std::size_t>(most);
  if (n <= m) return track;
  Track kept;
  for (std::size_t i = 0; i < m; ++i) kept.push_back(track[i * (n - 1) / (m - 1)]);
  return kept;
}

bool has_depth(const Track& track) {
  return std::any_of(track.begin(), track.end(),
                     [](const Sight& s) { return s.seen.depth_m > 0.0F; });
}

}  // namespace

void LandmarkStore::add(std::int64_t keyframe, std::vector<SeenFeature> seen) {
  keyframes_.emplace(keyframe, std::make_shared<const std::vector<SeenFeature>>(std::move(seen)));
}

void LandmarkStore::drop(std::int64_t keyframe) { keyframes_.erase(keyframe); }

std::int64_t LandmarkStore::landmark_of(std::int64_t keyframe, int feature) const {
  const auto found = keyframes_.find(keyframe);
  if (found == keyframes_.end()) return 0;
  const auto at =
      std::lower_bound(found->second->begin(), found->second->end(), feature,
                       [](const SeenFeature& seen, int index) { return seen.index < index; });
  return at != found->second->end() && at->index == feature ? at->landmark : 0;
}

std::vector<Track> LandmarkStore::tracks(const std::vector<SamePoints>& same,
                                         const TrackLimits& limits) const {
  Merged merged;
  for (const SamePoints& loop : same)
    for (const auto& [from, to] : loop.features) {
      const std::int64_t a = landmark_of(loop.from, from);
      const std::int64_t b = landmark_of(loop.to, to);
      if (a > 0 && b > 0) merged.join(a, b);
    }
  std::map<std::int64_t, Track> by_landmark;
  for (const auto& [id, features] : keyframes_)
    for (const SeenFeature& seen : *features) {
      Track& track = by_landmark[merged.root(seen.landmark)];
      if (track.empty() || track.back().keyframe != id) track.push_back({id, seen});
    }

  std::vector<Track> all;
  for (auto& [landmark, track] : by_landmark) {
    if (track.size() < 2) continue;
    Track kept = thinned(track, limits.most_per_track);
    if (has_depth(kept)) all.push_back(std::move(kept));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Track& a, const Track& b) { return a.size() > b.size(); });
  const int share =
      std::clamp(limits.most_views / static_cast<int>(std::max<std::size_t>(1, n_keyframes())),
                 limits.least_per_keyframe, limits.most_per_keyframe);
  std::map<std::int64_t, int> count;
  std::vector<Track> chosen;
  for (Track& track : all) {
    const bool wanted = std::any_of(track.begin(), track.end(),
                                    [&](const Sight& s) { return count[s.keyframe] < share; });
    if (!wanted) continue;
    for (const Sight& sight : track) ++count[sight.keyframe];
    chosen.push_back(std::move(track));
  }
  return chosen;
}

}  // namespace fusion_slam
