// Between the wire's types and the project's own. Pure functions; from_message never trusts what it
// reads: a quaternion that is not a rotation, a number that is not finite or a position beyond 1e9
// m gives nothing.
#pragma once

#include <optional>

#include "bot_core/pose_t.hpp"
#include "bot_core/rigid_transform_t.hpp"
#include "fusion_slam/tile_t.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/tiles/tile.hpp"

namespace fusion_slam {

bot_core::rigid_transform_t to_message(const SE3& T, std::int64_t utime_us);
std::optional<SE3> from_message(const bot_core::rigid_transform_t& message);

// Position and orientation; rates are 0 on the way out and ignored on the way in.
bot_core::pose_t to_pose_message(const SE3& T, std::int64_t utime_us);
std::optional<SE3> from_message(const bot_core::pose_t& message);

// Row-major double[36] of a message.
void to_message(const Matrix6d& covariance, double* out);
Matrix6d covariance_from_message(const double* in);  // not finite: a very wide one (1e6)

tile_t to_message(const Tile& tile);  // seq is left to the bus
Tile from_message(const tile_t& message);

}  // namespace fusion_slam
