// Where the LiDAR sits on the robot, from its motion and the wheels' (after Censi, Franchi,
// Marchionni & Oriolo 2013, "Simultaneous calibration of odometry and sensor parameters for mobile
// robots"): base is the point that the wheels' odometry speaks of. With A the robot's motion during
// a second by its wheels and B the LiDAR's by scan matching, A * X = X * B; the wheels' scales and
// clock are unknowns beside X. Pure, deterministic.
#pragma once

#include <optional>

#include "libs/calibration/drive.hpp"

namespace fusion_slam {

struct LidarOnWheels {
  SE2 T_base_lidar;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // of x, y, yaw in base
  double way_scale = 1.0;                                    // true way / the wheels' way
  double turn_scale = 1.0;                                   // true turn / the wheels' turn
  double delay_s = 0.0;     // of the wheels: their stamp + this is the LiDAR's clock
  double turned_rad = 0.0;  // in all, left and right: without turning x and y are not seen
};

// `start`: the mounting on paper. Nothing without odometry, or with less than 10 s or 3 rad of
// drive.
std::optional<LidarOnWheels> find_lidar_on_wheels(const PlanarPath& lidar,
                                                  const PlanarPath& odometry, const SE2& start);

}  // namespace fusion_slam
