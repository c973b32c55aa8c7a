#include "libs/scan_matching/twist.hpp"

#include <cmath>

namespace fusion_slam {

SE2 Twist::motion(double dt_s) const {
  const double a = turn_radps * dt_s;
  // Integral of the rotation: (sin a / a, (1 - cos a) / a).
  const double s = std::abs(a) < 1e-6 ? 1.0 - a * a / 6.0 : std::sin(a) / a;
  const double c = std::abs(a) < 1e-6 ? a / 2.0 : (1.0 - std::cos(a)) / a;
  return {(s * vx_mps - c * vy_mps) * dt_s, (c * vx_mps + s * vy_mps) * dt_s, wrap_angle(a)};
}

Twist Twist::from_motion(const SE2& motion, double dt_s) {
  const double a = motion.yaw;
  const double s = std::abs(a) < 1e-6 ? 1.0 - a * a / 6.0 : std::sin(a) / a;
  const double c = std::abs(a) < 1e-6 ? a / 2.0 : (1.0 - std::cos(a)) / a;
  const double det = s * s + c * c;
  return {(s * motion.x + c * motion.y) / det / dt_s, (s * motion.y - c * motion.x) / det / dt_s,
          a / dt_s};
}

}  // namespace fusion_slam
