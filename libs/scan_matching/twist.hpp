// Constant planar velocity: how a robot moves during and between sweeps.
#pragma once

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// In base axes.
struct Twist {
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double turn_radps = 0.0;

  // T_base(0)_base(dt_s): the motion during dt_s.
  SE2 motion(double dt_s) const;
  // The constant velocity that moves by `motion` in dt_s > 0.
  static Twist from_motion(const SE2& motion, double dt_s);
};

}  // namespace fusion_slam
