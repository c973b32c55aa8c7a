// When tracking was lost, why, and how it ended.
#pragma once

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "services/visual_odometry/tracking_result.hpp"

namespace fusion_slam {

class LostSpells {
 public:
  // `t_s`: since the recording's start. `relocalisations`: counted so far.
  void on(double t_s, const TrackingResult& result, int relocalisations) {
    const bool lost = result.state == TrackingState::kLost;
    if (lost && !now_lost_) spells_.push_back({t_s, t_s, result.reason, ""});
    if (!lost && now_lost_) {
      spells_.back().to_s = t_s;
      spells_.back().end = relocalisations > relocalisations_ ? "found again" : "new segment";
      if (result.keyframe && result.keyframe->previous_id == 0) spells_.back().end = "new segment";
    }
    now_lost_ = lost;
    relocalisations_ = relocalisations;
  }

  void print() const {
    for (const Spell& s : spells_)
      std::printf("LOST from %.3f s (%s) to %.3f s: %s\n", s.from_s, s.reason.c_str(), s.to_s,
                  s.end.empty() ? "the end" : s.end.c_str());
  }

 private:
  struct Spell {
    double from_s = 0.0;
    double to_s = 0.0;
    std::string reason;  // of its first frame
    std::string end;
  };
  std::vector<Spell> spells_;
  bool now_lost_ = false;
  int relocalisations_ = 0;
};

}  // namespace fusion_slam
