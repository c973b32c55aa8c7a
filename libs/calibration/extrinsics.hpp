// The mounting of a robot's two sensors from one ordinary drive: the floor gives the camera's
// height, roll and pitch; the wheels the LiDAR's place on the robot; the walls the camera's place
// against the LiDAR and the time between their clocks.
#pragma once

#include <optional>
#include <string>

#include "libs/calibration/drive.hpp"
#include "libs/calibration/floor.hpp"
#include "libs/calibration/walls.hpp"
#include "libs/calibration/wheels.hpp"

namespace fusion_slam {

struct Extrinsics {
  RobotModel robot;  // as on paper, with what was found
  std::optional<FloorView> floor;
  std::optional<LidarOnWheels> wheels;
  std::optional<CameraAgainstLidar> walls;
  // 1 sigma of the camera's x, y (m) and yaw (rad) in base; with wheels theirs is in it.
  Eigen::Vector3d camera_sigma = Eigen::Vector3d::Zero();
};

Extrinsics calibrate_extrinsics(const CalibrationDrive& recorded);

// For people: each number with its sigma, what was not seen and what to drive for it, and the lines
// for the robot's and the camera's file.
std::string report(const Extrinsics& found, const RobotModel& on_paper);

}  // namespace fusion_slam
