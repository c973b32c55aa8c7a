// Poses of a differential drive from its encoders.
#pragma once

#include <cstdint>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct WheelTicks {
  std::int64_t utime_us = 0;
  std::int64_t left = 0;
  std::int64_t right = 0;
};

struct WheelGeometry {
  double metres_per_tick = 0.0;
  double wheel_base_m = 0.0;  // between the wheels' contact points
};

// MAEBot: 4366 ticks on 3 feet (0.9144 m), wheels 8 cm apart, as its students' code has it.
// Regression of the real recording's encoders on its SLAM poses gives 2.007e-4 m a tick (of chords,
// so a lower bound) and 0.002608 rad a tick of difference, which is 0.0803 m at the nominal scale
// (docs/import.md).
inline constexpr WheelGeometry kMaebotWheels{0.9144 / 4366.0, 0.080};
// MinesRover (BreezySLAM's description): wheel radius 77 mm, half axle 165 mm, 2000 ticks a turn.
inline constexpr WheelGeometry kMinesRoverWheels{2.0 * M_PI * 0.077 / 2000.0, 0.330};

// T_a_b, the motion of base from ticks a to ticks b on a circular arc.
SE2 wheel_motion(const WheelGeometry& wheels, const WheelTicks& a, const WheelTicks& b);

}  // namespace fusion_slam
