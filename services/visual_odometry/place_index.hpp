// Which keyframes may show the place that the camera sees now, whatever the pose: landmarks of the
// whole map in an index of binary descriptors, and votes (Nister & Stewenius 2006 for the idea;
// here without a vocabulary: bit-sampling hashes, libs/features/lsh_index).
#pragma once

#include <cstdint>
#include <vector>

#include "libs/features/lsh_index.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

constexpr int kNoSegment = 0;  // segments begin at 1

class PlaceIndex {
 public:
  PlaceIndex();

  // Remembers the landmarks born at this keyframe that have lasted until now. Each keyframe once.
  void add(const VisualMap& map, std::int64_t keyframe);
  // Also these landmarks. Each once.
  void add_landmarks(const VisualMap& map, const std::vector<std::int64_t>& ids);

  // The keyframes of the map that see most of the landmarks that the features resemble, best
  // first, at most `most`, no two of them neighbours in time.
  // Keyframes of `except_segment` are left out.
  std::vector<std::int64_t> similar(const VisualMap& map, const FeatureSet& set, int except_segment,
                                    std::size_t most) const;

  // Landmarks, with those that have gone from the map since it was last looked through: at most
  // half as many again as are there, or 65536.
  std::size_t size() const { return index_.size(); }

 private:
  void forget_gone(const VisualMap& map);

  LshIndex index_;
  std::size_t look_through_at_;  // so many landmarks
};

}  // namespace fusion_slam
