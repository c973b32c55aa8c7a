// What the keyframes saw of the world's points, kept for global bundle adjustment, and the points'
// tracks through all keyframes. A loop's pairs of features make one point of two.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "libs/graph/node_id.hpp"
#include "libs/journal/note_bytes.hpp"

namespace fusion_slam {

struct SeenFeature {
  std::int64_t landmark = 0;  // as the tracker named it, > 0
  int index = 0;              // among the keyframe's features
  float u_px = 0.0F;          // ideal pixel
  float v_px = 0.0F;
  float depth_m = 0.0F;  // 0: none
  float depth_sigma_m = 0.0F;
  std::int8_t octave = 0;
};

struct Sight {
  std::int64_t keyframe = 0;
  SeenFeature seen;
};
using Track = std::vector<Sight>;  // of one point, by keyframe, at most one a keyframe

// Two keyframes and the features (indices) that show the same points, as a loop found them.
struct SamePoints {
  std::int64_t from = 0;
  std::int64_t to = 0;
  std::vector<std::pair<int, int>> features;
};

struct TrackLimits {
  int most_views = 100'000;     // of all tracks together, about
  int least_per_keyframe = 60;  // however many keyframes there are
  int most_per_keyframe = 300;
  int most_per_track = 24;  // more are thinned evenly: a reduced system grows with their square
};

// Not thread-safe; a copy may be read by another thread.
class LandmarkStore {
 public:
  // `seen` in the order of their indices. A keyframe that is there already is left as it is.
  void add(std::int64_t keyframe, std::vector<SeenFeature> seen);
  void drop(std::int64_t keyframe);
  std::size_t n_keyframes() const { return keyframes_.size(); }

  // Points seen from at least two keyframes, once with depth: the longest tracks first until every
  // keyframe has its share. Deterministic: keyframes and landmarks in the order of their ids.
  std::vector<Track> tracks(const std::vector<SamePoints>& same, const TrackLimits& limits) const;

  void write(NoteWriter* out) const;  // for the journal
  void read(NoteReader* in);          // all of it; whether it was good, `in` says

 private:
  std::int64_t landmark_of(std::int64_t keyframe, int feature) const;  // 0: none

  using Seen = std::shared_ptr<const std::vector<SeenFeature>>;  // shared by copies
  std::map<std::int64_t, Seen> keyframes_;
};

}  // namespace fusion_slam
