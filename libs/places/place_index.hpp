// Stage 1: which older keyframes look like this one? Each descriptor asked votes for the keyframes
// that have one like it. Grows with each keyframe that is kept; no vocabulary. Not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "libs/features/lsh_index.hpp"
#include "libs/places/config.hpp"

namespace fusion_slam {

class PlaceIndex {
 public:
  explicit PlaceIndex(const AppearanceConfig& config);

  struct Place {
    std::int64_t id = 0;
    int votes = 0;
    double share = 0.0;  // of the features that were asked
  };
  // Most votes first, those above the threshold, at most max_candidates.
  std::vector<Place> like(const FeatureSet& features) const;

  // The keyframe becomes a place when it is old enough, so that the newest never drown the others'
  // votes. Ids must grow. Returned: those that became places now.
  std::vector<std::int64_t> add(std::int64_t id, std::int64_t utime_us, const FeatureSet& features);
  // No place any more; not one: nothing happens.
  void remove(std::int64_t id);

  // All places, in the order of their ids.
  const std::map<std::int64_t, int>& places() const { return labels_; }

  std::size_t n_places() const { return labels_.size(); }

 private:
  struct Waiting {
    std::int64_t id = 0;
    std::int64_t utime_us = 0;
    std::vector<Descriptor> descriptors;
  };
  static std::vector<Descriptor> sample(const FeatureSet& features, int at_most);

  AppearanceConfig config_;
  LshIndex index_;
  std::deque<Waiting> waiting_;
  std::vector<std::int64_t> ids_;       // by label, which grows with the id
  mutable std::vector<int> votes_;      // by label; all 0 between calls
  std::map<std::int64_t, int> labels_;  // by id
};

}  // namespace fusion_slam
