// From ranges to points: the first step of the mapper. Pure functions.
#pragma once

#include "libs/robot/robot_model.hpp"
#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// Constant planar velocity in base axes.
struct Twist {
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double turn_radps = 0.0;

  // T_base(0)_base(dt_s): the motion during dt_s.
  SE2 motion(double dt_s) const;
  // The constant velocity that moves by `motion` in dt_s > 0.
  static Twist from_motion(const SE2& motion, double dt_s);
};

struct ScanPoints {
  Points hits_base;  // end points in base at the time of the first beam, in the order of the beams
  // Between end points that lie on one surface (surface_fill): for the map, not for matching.
  Points surface_base;
  Eigen::Vector2d origin_base =
      Eigen::Vector2d::Zero();  // of the beams, at the middle of the sweep
  int n_invalid = 0;            // nan, inf, zero, or out of the sensor's range: no return
};

// Beam i is taken to be measured where the robot is i * beam_period_s after the first one when it
// moves with `twist`: that removes the distortion by motion. Mounting as T_base_lidar says, upside
// down included; heights are dropped.
ScanPoints read_scan(const LaserScan& scan, const RobotModel& robot, const Twist& twist,
                     double max_range_m);

}  // namespace fusion_slam
