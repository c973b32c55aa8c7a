// When tracking was lost, why, and how it ended: found again, or a new segment that joined the old
// map later.
#pragma once

#include <string>
#include <vector>

#include "libs/evaluation/trajectory.hpp"
#include "services/visual_odometry/tracking_result.hpp"

namespace fusion_slam {

class LostSpells {
 public:
  void on(const TrackingResult& result, const VisualOdometryCounts& counts);

  // A line a spell, times in seconds since `start_us`. With the truth also since when a known place
  // was in sight: the true pose within 1 m and 30 degrees of where a keyframe was made before the
  // loss.
  void print(std::int64_t start_us, const Trajectory& truth) const;

 private:
  struct Spell {
    std::int64_t from_us = 0;
    std::int64_t to_us = 0;     // first frame that has a pose again; 0: the end
    std::int64_t known_us = 0;  // found again or joined; 0: never
    std::string reason;         // of its first frame
  };
  std::vector<Spell> spells_;
  std::vector<std::int64_t> keyframes_us_;
  VisualOdometryCounts counts_;
  bool now_lost_ = false;
};

}  // namespace fusion_slam
