#include "tests/bench/visual_odometry/lost_spells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fusion_slam {
namespace {

constexpr double kPatience_s = 0.6;  // a new segment starts so long after the camera sees again
constexpr double kNear_m = 1.0;
constexpr double kNear_rad = M_PI / 6.0;

SE3 true_pose(const Trajectory& truth, std::int64_t utime_us) {
  const auto at =
      std::lower_bound(truth.begin(), truth.end(), utime_us * 1e-6 - 1e-4,
                       [](const StampedPose& pose, double time_s) { return pose.time_s < time_s; });
  return at == truth.end() ? truth.back().T_world_body : at->T_world_body;
}

}  // namespace

void LostSpells::on(const TrackingResult& result, const VisualOdometryCounts& counts) {
  const bool lost = result.state == TrackingState::kLost;
  if (lost && !now_lost_) spells_.push_back({result.utime_us, 0, 0, result.reason});
  if (!lost && now_lost_) spells_.back().to_us = result.utime_us;
  const bool known =
      counts.relocalisations > counts_.relocalisations || counts.joins > counts_.joins;
  if (known && !spells_.empty() && spells_.back().known_us == 0)
    spells_.back().known_us = result.utime_us;
  if (result.keyframe) keyframes_us_.push_back(result.utime_us);
  now_lost_ = lost;
  counts_ = counts;
}

void LostSpells::print(std::int64_t start_us, const Trajectory& truth) const {
  const auto seconds = [&](std::int64_t utime_us) { return (utime_us - start_us) * 1e-6; };
  for (const Spell& s : spells_) {
    std::printf("LOST from %.3f s (%s)", seconds(s.from_us), s.reason.c_str());
    if (s.to_us != 0)
      std::printf(" to %.3f s: %s", seconds(s.to_us),
                  s.known_us == s.to_us ? "found again" : "new segment");
    if (s.known_us > s.to_us) std::printf(", joined at %.3f s", seconds(s.known_us));
    const auto in_sight = std::find_if(truth.begin(), truth.end(), [&](const StampedPose& pose) {
      return s.to_us != 0 && pose.time_s > s.to_us * 1e-6 - kPatience_s &&
             std::any_of(keyframes_us_.begin(), keyframes_us_.end(), [&](std::int64_t us) {
               if (us >= s.from_us) return false;
               const Vector6d apart = local(true_pose(truth, us), pose.T_world_body);
               return apart.head<3>().norm() < kNear_m && apart.tail<3>().norm() < kNear_rad;
             });
    });
    if (in_sight != truth.end())
      std::printf("; a known place in sight from %.3f s", in_sight->time_s - start_us * 1e-6);
    std::printf("\n");
  }
}

}  // namespace fusion_slam
