#include "libs/datasets/wheel_odometry.hpp"

#include <cmath>

namespace fusion_slam {

SE2 wheel_motion(const WheelGeometry& wheels, const WheelTicks& a, const WheelTicks& b) {
  const double left_m =
      (static_cast<double>(b.left) - static_cast<double>(a.left)) * wheels.metres_per_tick;
  const double right_m =
      (static_cast<double>(b.right) - static_cast<double>(a.right)) * wheels.metres_per_tick;
  const double yaw = (right_m - left_m) / wheels.wheel_base_m;
  const double arc_m = 0.5 * (left_m + right_m);
  // Chord of the arc: its length is arc * sin(yaw/2) / (yaw/2), its direction yaw/2.
  const double half = 0.5 * yaw;
  const double chord_m = std::abs(half) < 1e-6 ? arc_m : arc_m * std::sin(half) / half;
  return {chord_m * std::cos(half), chord_m * std::sin(half), wrap_angle(yaw)};
}

}  // namespace fusion_slam
