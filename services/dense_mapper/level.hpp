// Where up and the floor are, for a camera carried by hand: found from the surfaces it has seen (a
// Manhattan-like world: much of a room is level or upright) with the images' own up direction as
// the starting point.
#pragma once

#include <optional>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "services/dense_mapper/depth_cloud.hpp"

namespace fusion_slam {

// The levelled map frame: z up, z = 0 on the floor, x and y as in map up to the smallest rotation
// that makes z upright.
struct Level {
  SE3 T_level_map = SE3::Identity();
  bool floor_seen = false;  // false: z = 0 is the height that 98 % of what was seen is above
};

// Surfaces and camera positions in the map frame; image_up: mean up direction of the images, map
// frame. Nothing when there are too few surfaces. Pure and deterministic.
std::optional<Level> estimate_level(const std::vector<SurfacePoint>& surfaces,
                                    const Eigen::Vector3d& image_up,
                                    const std::vector<Eigen::Vector3d>& camera_positions_m);

// The smallest rotation that takes `up` (unit) to z.
Eigen::Matrix3d rotation_to_z(const Eigen::Vector3d& up);

}  // namespace fusion_slam
