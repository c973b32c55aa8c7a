#include "libs/places/place_index.hpp"

#include <algorithm>
#include <utility>

namespace fusion_slam {
namespace {

constexpr std::uint32_t kIndexSeed = 20251;  // any; the same in every run

}  // namespace

PlaceIndex::PlaceIndex(const AppearanceConfig& config)
    : config_(config), index_(config.index_tables, config.index_key_bits, kIndexSeed) {}

std::vector<std::int64_t> PlaceIndex::add(std::int64_t id, std::int64_t utime_us,
                                          const FeatureSet& features) {
  std::vector<std::int64_t> added;
  waiting_.push_back({id, utime_us, sample(features, config_.indexed_features)});
  while (waiting_.size() > static_cast<std::size_t>(config_.not_before_keyframes) &&
         utime_us - waiting_.front().utime_us >= config_.not_before_us) {
    const int label = static_cast<int>(ids_.size());
    ids_.push_back(waiting_.front().id);
    votes_.push_back(0);
    for (const Descriptor& d : waiting_.front().descriptors) index_.add(d, label);
    labels_[ids_.back()] = label;
    added.push_back(ids_.back());
    waiting_.pop_front();
  }
  return added;
}

void PlaceIndex::remove(std::int64_t id) {
  const auto label = labels_.find(id);
  if (label == labels_.end()) return;
  index_.remove(label->second);
  labels_.erase(label);
}

// Evenly over the set: features come octave by octave, and each octave should be asked.
std::vector<Descriptor> PlaceIndex::sample(const FeatureSet& features, int at_most) {
  const std::size_t most = static_cast<std::size_t>(at_most);
  if (features.size() <= most) return features.descriptors;
  std::vector<Descriptor> asked;
  for (std::size_t i = 0; i < most; ++i)
    asked.push_back(features.descriptors[i * features.size() / most]);
  return asked;
}

std::vector<PlaceIndex::Place> PlaceIndex::like(const FeatureSet& features) const {
  const std::vector<Descriptor> asked = sample(features, config_.asked_features);
  std::vector<int> touched;
  for (const Descriptor& d : asked) {
    int last = -1;  // neighbours come in the order they were added: those of a place together
    for (const LshIndex::Near& n : index_.near(d, config_.max_distance)) {
      if (n.label != last && votes_[static_cast<std::size_t>(n.label)]++ == 0)
        touched.push_back(n.label);
      last = n.label;
    }
  }
  std::sort(touched.begin(), touched.end());
  std::vector<Place> places;
  for (const int label : touched) {
    const int count = std::exchange(votes_[static_cast<std::size_t>(label)], 0);
    const double share = count / static_cast<double>(asked.size());
    if (share >= config_.min_votes)
      places.push_back({ids_[static_cast<std::size_t>(label)], count, share});
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.votes > b.votes; });
  if (places.size() > static_cast<std::size_t>(config_.max_candidates))
    places.resize(static_cast<std::size_t>(config_.max_candidates));
  return places;
}

}  // namespace fusion_slam
