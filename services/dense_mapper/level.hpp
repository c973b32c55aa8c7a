// Where up and the floor are, for a camera carried by hand: found from the surfaces it has seen (a
// Manhattan-like world: much of a room is level or upright) with the images' own up direction as
// the starting point.
#pragma once

#include <optional>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "services/dense_mapper/depth_cloud.hpp"

namespace fusion_slam {

// How the map frame has to move to be level: z up, z = 0 on the floor, x and y as they are, up to
// the smallest rotation that makes z upright.
struct Level {
  SE3 T_level_map = SE3::Identity();
  bool floor_seen = false;  // false: z = 0 is the height that 98 % of what was seen is above
};

// Surfaces and camera positions in the map frame; image_up: mean up direction of the images, map
// frame. Nothing when there are too few surfaces. Pure and deterministic.
std::optional<Level> estimate_level(const std::vector<SurfacePoint>& surfaces,
                                    const Eigen::Vector3d& image_up,
                                    const std::vector<Eigen::Vector3d>& camera_positions_m);

// True when the map is off level by more than is worth moving all of it: 5 mrad, or half a cell in
// height.
bool worth_levelling(const SE3& T_level_map, double resolution_m);

// How well a level is known, as a covariance of T_level_anchor (xi in T * Exp(xi)): z, roll and
// pitch tight, x, y and yaw as good as unknown.
Matrix6d level_covariance(const SE3& T_level_anchor, bool floor_seen);

}  // namespace fusion_slam
