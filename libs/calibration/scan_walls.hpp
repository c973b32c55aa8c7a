// The walls that scans draw along a path, and the path that fits its own walls best. Pure,
// deterministic.
#pragma once

#include <vector>

#include "libs/calibration/planar_path.hpp"
#include "libs/robot/robot_model.hpp"
#include "libs/scan_matching/surface_map.hpp"

namespace fusion_slam {

// A pose somewhere in a sweep: where a beam of it ended, in the LiDAR's frame at its time.
struct BeamPoint {
  double utime_us = 0.0;
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
};
std::vector<BeamPoint> beam_points(const LaserScan& scan, const LidarModel& lidar);

// Of the scans stamped within [begin_us, end_us], each beam from where `path` (T_odom_lidar) was at
// its time.
SurfaceMap draw_walls(const std::vector<LaserScan>& scans, const LidarModel& lidar,
                      const PlanarPath& path, double begin_us, double end_us, double cell_m);

// All poses of the path at once so that every beam lies on the walls of its neighbourhood in time:
// point-to-line, corrections linear between the poses, walls drawn anew each round. A front end
// that goes scan by scan predicts the motion during a sweep and keeps some of that in what it finds
// (a LiDAR turning with the robot seemed to sit 1 cm beside its place); here nothing is predicted.
PlanarPath refine_path(const std::vector<LaserScan>& scans, const LidarModel& lidar,
                       const PlanarPath& path, int rounds = 6);

}  // namespace fusion_slam
