// configuration.yaml of a map directory: the effective configuration the map was made with, for
// people and for other programs. ROBOT_MODEL and CAMERA_MODEL in the journal say the same.
#pragma once

#include <optional>
#include <string>

#include "libs/camera/camera_model.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

// Poses of sensors as [x, y, z, qw, qx, qy, qz] in base; the camera's is its optical frame's.
std::string configuration_yaml(const RobotModel& robot, const std::optional<CameraModel>& camera);

}  // namespace fusion_slam
