// Where the camera stands against the LiDAR, and how their clocks differ: what depth sees at the
// LiDAR's height must lie on the walls that the LiDAR saw. The walls: the scans around a moment,
// each beam where the LiDAR was at its time. The unknowns: the camera in the LiDAR's plane, and the
// time that must be added to its stamps; point-to-line distances (Censi 2008), Gauss-Newton from
// several times, the blocks' jackknife for the uncertainty. Pure, deterministic.
#pragma once

#include <optional>

#include "libs/calibration/drive.hpp"
#include "libs/calibration/floor.hpp"

namespace fusion_slam {

struct CameraAgainstLidar {
  SE2 T_lidar_camera;    // of the camera's level frame: x is where it looks, as seen from above
  double delay_s = 0.0;  // camera's stamp + this is the LiDAR's clock
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  // x, y, yaw, delay
  std::size_t n_points = 0;                                  // on walls
  double rms_m = 0.0;                                        // of their distances
};

// One point of a slice: in the camera's level frame, seen from above.
struct SlicePoint {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  // unit, towards the camera; zero: none
  double sigma_m = 0.0;                              // along the ray
};

// The frame's depth within `half_m` of a height above the floor, one point a column.
std::vector<SlicePoint> slice(const DepthFrame& frame, const CameraModel& camera,
                              const FloorView& floor, double height_m, double half_m = 0.04);

// `start`: the mounting on paper. Nothing when too few points find a wall.
std::optional<CameraAgainstLidar> align_to_walls(const CalibrationDrive& drive,
                                                 const FloorView& floor, const SE2& start);

}  // namespace fusion_slam
