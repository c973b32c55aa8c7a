#include "drivers/simulator/hand_held.hpp"

#include <cmath>

#include "drivers/simulator/random.hpp"

namespace fusion_slam {
namespace {
constexpr std::uint64_t kSwayStream = 40;
}

HandHeldSway::HandHeldSway(const HandHeld& carried, std::uint64_t seed) : carried_(carried) {
  Random random(seed, kSwayStream);
  constexpr double kBands[3][3] = {{0.62, 0.05, 0.2}, {0.28, 0.3, 0.8}, {0.10, 1.6, 2.2}};
  for (auto& axis : waves_)
    for (std::size_t k = 0; k < 3; ++k)
      axis[k] = {kBands[k][0], 2.0 * M_PI * random.uniform(kBands[k][1], kBands[k][2]),
                 random.uniform(0.0, 2.0 * M_PI)};
}

double HandHeldSway::wave(std::size_t axis, double time_s) const {
  double sum = 0.0;
  for (const Wave& w : waves_[axis]) sum += w.share * std::sin(w.rad_s * time_s + w.phase_rad);
  return sum;
}

SE3 HandHeldSway::T_path_base(double time_s) const {
  return from_xyz_rpy(carried_.sway_ahead_m * wave(0, time_s),
                      carried_.sway_aside_m * wave(1, time_s),
                      carried_.height_m + carried_.sway_height_m * wave(2, time_s),
                      carried_.sway_roll_rad * wave(3, time_s),
                      carried_.pitch_rad + carried_.sway_pitch_rad * wave(4, time_s),
                      carried_.sway_yaw_rad * wave(5, time_s));
}

}  // namespace fusion_slam
