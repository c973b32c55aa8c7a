#include "services/visual_odometry/place_index.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

constexpr int kTables = 6;
constexpr int kKeyBits = 16;
constexpr int kVoteDistance = 48;    // bits: stricter than matching, for all the map is asked
constexpr std::size_t kAsked = 400;  // features of the frame, evenly
constexpr int kMinVotes = 8;
constexpr std::int64_t kOnePlace = 3;  // keyframes with ids so near show one place
constexpr std::size_t kFirstLook = 65536;

}  // namespace

PlaceIndex::PlaceIndex() : index_(kTables, kKeyBits, 1), look_through_at_(kFirstLook) {}

void PlaceIndex::add(const VisualMap& map, std::int64_t keyframe) {
  const MapKeyframe* known = map.keyframe(keyframe);
  if (known == nullptr) return;
  if (index_.size() >= look_through_at_) forget_gone(map);
  for (const std::int64_t id : known->landmark_of_feature) {
    const Landmark* landmark = id == 0 ? nullptr : map.landmark(id);
    if (landmark != nullptr && landmark->born == keyframe)
      index_.add(landmark->descriptor, static_cast<int>(id));
  }
}

// Most landmarks are fused with others sooner or later, or culled.
void PlaceIndex::forget_gone(const VisualMap& map) {
  index_.keep_only([&](int id) { return map.landmark(id) != nullptr; });
  look_through_at_ = std::max(kFirstLook, index_.size() + index_.size() / 2);
}

void PlaceIndex::add_landmarks(const VisualMap& map, const std::vector<std::int64_t>& ids) {
  for (const std::int64_t id : ids)
    if (const Landmark* landmark = map.landmark(id))
      index_.add(landmark->descriptor, static_cast<int>(id));
}

std::vector<std::int64_t> PlaceIndex::similar(const VisualMap& map, const FeatureSet& set,
                                              int except_segment, std::size_t most) const {
  std::map<std::int64_t, int> votes;
  const std::size_t step = std::max<std::size_t>(1, set.size() / kAsked);
  for (std::size_t i = 0; i < set.size(); i += step) {
    const std::vector<LshIndex::Near> near = index_.near(set.descriptors[i], kVoteDistance);
    const auto nearest =
        std::min_element(near.begin(), near.end(),
                         [](const auto& a, const auto& b) { return a.distance < b.distance; });
    if (nearest == near.end()) continue;
    const Landmark* landmark = map.landmark(nearest->label);
    if (landmark == nullptr) continue;
    for (const Observation& o : landmark->observations) ++votes[o.keyframe];
  }
  std::vector<std::pair<int, std::int64_t>> ranked;
  for (const auto& [id, n] : votes) {
    const MapKeyframe* keyframe = map.keyframe(id);
    if (n >= kMinVotes && keyframe != nullptr && keyframe->segment != except_segment)
      ranked.emplace_back(-n, -id);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::int64_t> best;
  for (const auto& [n, id] : ranked) {
    if (best.size() >= most) break;
    const std::int64_t keyframe = -id;
    if (std::none_of(best.begin(), best.end(),
                     [&](std::int64_t b) { return std::abs(b - keyframe) < kOnePlace; }))
      best.push_back(keyframe);
  }
  return best;
}

}  // namespace fusion_slam
