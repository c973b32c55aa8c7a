// Depth for features from the LiDAR where its plane crosses what the camera sees.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"
#include "services/visual_odometry/config.hpp"

namespace fusion_slam {

// A scan's returns as they lie in base at the time of the frame, in order of the beams; a gap (no
// return) is a point that is not finite.
using ScanInBase = std::vector<Eigen::Vector3d>;

// `twist_base` (per second: translation m, rotation rad, base axes) is the robot's motion around
// the frame: it carries each beam from its own time to frame_utime_us.
ScanInBase scan_at(const LaserScan& scan, const RobotModel& robot, const Vector6d& twist_base,
                   std::int64_t frame_utime_us);

// Gives features the LiDAR's depth where that is better. Two neighbouring returns on one surface
// span an upright patch (walls, legs, doors and cupboards are upright); a feature whose ray meets
// the patch near the LiDAR's plane takes its depth when it has none of its own, and farther from
// the plane when its own depth agrees (3 sigma) and is less certain. Positions must be ideal
// pixels. Returns how many features were changed.
int attach_lidar_depth(const ScanInBase& scan, const RobotModel& robot, const CameraModel& camera,
                       const VisualOdometryConfig& config, FeatureSet* set);

}  // namespace fusion_slam
