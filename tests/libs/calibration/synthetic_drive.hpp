// A drive through a room with boxes, each measurement computed from its definition: slow, obvious.
#pragma once

#include "libs/calibration/drive.hpp"

namespace fusion_slam {

struct DriveTruth {
  SE2 T_base_lidar{0.08, -0.03, 0.04};
  SE3 T_base_camera;       // optical
  double delay_s = 0.030;  // camera's stamp + this is the LiDAR's clock
  double wheel_delay_s = 0.015;
  double way_scale = 1.01;  // true way / the wheels' way
  double range_sigma_m = 0.0;
  double depth_sigmas = 0.0;  // of the camera's own noise

  DriveTruth();
};

// What the sensors saw in `seconds`; robot holds the mounting on paper: LiDAR at the centre, camera
// level 0.1 m ahead and 0.35 m above.
CalibrationDrive synthetic_drive(const DriveTruth& truth, double seconds);

// The robot's true pose (smooth, with turns both ways).
SE2 true_pose(double time_s);

}  // namespace fusion_slam
