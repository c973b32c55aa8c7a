// CAMERA_MODEL, ROBOT_MODEL and LIDAR between the wire and the project's own types. from_message
// gives nothing, with a reason in `why`, when a number can't be what it says (negative size, not
// finite, not a rotation).
#pragma once

#include <optional>
#include <string>

#include "bot_core/planar_lidar_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/camera/camera_model.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

camera_model_t to_message(const CameraModel& model, std::int64_t utime_us);
std::optional<CameraModel> from_message(const camera_model_t& message, std::string* why);

robot_model_t to_message(const RobotModel& model, std::int64_t utime_us);
std::optional<RobotModel> from_message(const robot_model_t& message, std::string* why);

bot_core::planar_lidar_t to_message(const LaserScan& scan);
std::optional<LaserScan> from_message(const bot_core::planar_lidar_t& message, std::string* why);

const char* to_string(ReferenceFrame frame);
std::optional<ReferenceFrame> reference_frame_from(const std::string& text);

}  // namespace fusion_slam
