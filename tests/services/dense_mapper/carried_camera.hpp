// A camera carried by hand through the synthetic room: the map frame is the first camera turned to
// x forward, z up, so it is as tilted as that camera was.
#pragma once

#include <map>

#include "libs/robot/robot_model.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"

namespace fusion_slam {

constexpr double kCarriedHeightM = 1.3;
constexpr double kCarriedPitchRad = 0.5;

inline RobotModel carried_robot() {
  RobotModel robot;
  robot.has_camera = true;
  robot.planar = false;
  robot.T_base_camera.linear() = optical_to_body();
  return robot;
}

// T_room_base of keyframes 1 to n.
inline std::map<std::int64_t, SE3> carry(int n) {
  std::map<std::int64_t, SE3> poses;
  for (int i = 0; i < n; ++i)
    poses[i + 1] = from_xyz_rpy(-0.5 + 0.05 * i, 0.03 * (i % 3), kCarriedHeightM + 0.01 * (i % 2),
                                0.0, kCarriedPitchRad, 0.1 * (i % 3));
  return poses;
}

}  // namespace fusion_slam
