#include "libs/messages/convert.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

// Further out nothing drives; a number that large would be damage, and products of it not finite.
constexpr double kMaxPositionM = 1e9;

std::optional<SE3> pose_from(const double* position, const double* wxyz) {
  double norm = 0.0;
  for (int i = 0; i < 4; ++i) norm += wxyz[i] * wxyz[i];
  if (!std::isfinite(norm) || norm < 0.5 || norm > 2.0) return std::nullopt;
  const Eigen::Vector3d p(position[0], position[1], position[2]);
  if (!(p.cwiseAbs().maxCoeff() <= kMaxPositionM) || !p.allFinite()) return std::nullopt;
  return make_pose(p, wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}

void pose_to(const SE3& T, double* position, double* wxyz) {
  const Eigen::Quaterniond q(T.linear());
  for (int i = 0; i < 3; ++i) position[i] = T.translation()[i];
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  wxyz[0] = sign * q.w();
  wxyz[1] = sign * q.x();
  wxyz[2] = sign * q.y();
  wxyz[3] = sign * q.z();
}

}  // namespace

bot_core::rigid_transform_t to_message(const SE3& T, std::int64_t utime_us) {
  bot_core::rigid_transform_t message{};
  message.utime = utime_us;
  pose_to(T, message.trans, message.quat);
  return message;
}

std::optional<SE3> from_message(const bot_core::rigid_transform_t& message) {
  return pose_from(message.trans, message.quat);
}

bot_core::pose_t to_pose_message(const SE3& T, std::int64_t utime_us) {
  bot_core::pose_t message{};
  message.utime = utime_us;
  pose_to(T, message.pos, message.orientation);
  return message;
}

std::optional<SE3> from_message(const bot_core::pose_t& message) {
  return pose_from(message.pos, message.orientation);
}

void to_message(const Matrix6d& covariance, double* out) {
  for (int row = 0; row < 6; ++row)
    for (int col = 0; col < 6; ++col) out[6 * row + col] = covariance(row, col);
}

Matrix6d covariance_from_message(const double* in) {
  Matrix6d covariance;
  for (int row = 0; row < 6; ++row)
    for (int col = 0; col < 6; ++col) covariance(row, col) = in[6 * row + col];
  if (!covariance.allFinite()) return Matrix6d::Identity() * 1e6;
  return covariance;
}

tile_t to_message(const Tile& tile) {
  tile_t message{};
  message.utime = tile.utime_us;
  message.submap_id = tile.key.submap_id;
  message.x = tile.key.x;
  message.y = tile.key.y;
  message.z = tile.key.z;
  message.revision = tile.revision;
  message.resolution_m = tile.resolution_m;
  message.size_cells = tile.size_cells;
  message.encoding = static_cast<std::int8_t>(tile.encoding);
  message.size_bytes = static_cast<std::int32_t>(tile.data.size());
  message.data = tile.data;
  return message;
}

Tile from_message(const tile_t& message) {
  Tile tile;
  tile.key = {message.submap_id, message.x, message.y, message.z};
  tile.utime_us = message.utime;
  tile.revision = message.revision;
  tile.resolution_m = message.resolution_m;
  tile.size_cells = message.size_cells;
  tile.encoding = static_cast<TileEncoding>(message.encoding);
  tile.data = message.data;
  return tile;
}

}  // namespace fusion_slam
