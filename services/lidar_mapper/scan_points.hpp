// From ranges to points: the first step of the mapper. Pure functions.
#pragma once

#include "libs/robot/robot_model.hpp"
#include "libs/scan_matching/surface_refiner.hpp"

namespace fusion_slam {

struct ScanPoints {
  SweepPoints sweep;  // in base as it stood at each beam, in the order of the beams
  Points hits_base;   // the same in base at the time of the first beam: distortion removed
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

// A scan again from its returns in base, distortion removed, in the order of the beams (what
// LIDAR_NODE carries). The angle between beams is taken to be the median of neighbours'.
ScanPoints points_again(Points hits_base, const RobotModel& robot);

// Removes the distortion anew, for a robot that moved with `twist` during the sweep.
void straighten(const LaserScan& scan, const RobotModel& robot, const Twist& twist,
                ScanPoints& points);

}  // namespace fusion_slam
