#include "libs/cloud/cloud_tile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libs/tiles/packed_tile.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kPointBytes = 9;
constexpr double kUnitsPerEdge = 65536.0;
constexpr double kMaxResolutionM = 1000.0;  // with any tile index, points stay far inside a float

std::array<std::int32_t, 3> indices(const TileKey& key) { return {key.x, key.y, key.z}; }

double units_of(float p_m, double edge_m, std::int32_t index) {
  const double offset = p_m / edge_m - index;
  return std::clamp(std::floor(offset * kUnitsPerEdge), 0.0, kUnitsPerEdge - 1.0);
}

float centre_of(double units, double edge_m, std::int32_t index) {
  return static_cast<float>((index + (units + 0.5) / kUnitsPerEdge) * edge_m);
}

// Which of `size` points is the i-th of the n that are kept.
std::size_t kept(std::size_t i, std::size_t size, std::size_t n) { return i * size / n; }

}  // namespace

TileKey cloud_tile_of(std::int64_t submap_id, const Eigen::Vector3d& p_m, double resolution_m) {
  const double edge_m = kCloudTileVoxels * resolution_m;
  TileKey key;
  key.submap_id = submap_id;
  key.x = static_cast<std::int32_t>(std::floor(p_m.x() / edge_m));
  key.y = static_cast<std::int32_t>(std::floor(p_m.y() / edge_m));
  key.z = static_cast<std::int32_t>(std::floor(p_m.z() / edge_m));
  return key;
}

Tile encode_cloud_tile(const TileKey& key, const std::vector<ColouredPoint>& points,
                       double resolution_m, std::int64_t revision, std::int64_t utime_us) {
  if (points.empty()) return cloud_tile_of_packed(key, {}, resolution_m, revision, utime_us);
  const std::size_t n = std::min(points.size(), kCloudTileMaxPoints);
  const double edge_m = kCloudTileVoxels * resolution_m;
  std::vector<std::uint8_t> raw(n * kPointBytes);
  for (std::size_t i = 0; i < n; ++i) {
    const ColouredPoint& point = points[kept(i, points.size(), n)];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = static_cast<std::uint32_t>(
          units_of(point.p_m[static_cast<Eigen::Index>(axis)], edge_m, indices(key)[axis]));
      raw[2 * (axis * n + i)] = static_cast<std::uint8_t>(value & 0xFFU);
      raw[2 * (axis * n + i) + 1] = static_cast<std::uint8_t>(value >> 8U);
    }
    raw[6 * n + i] = point.r;
    raw[7 * n + i] = point.g;
    raw[8 * n + i] = point.b;
  }
  return cloud_tile_of_packed(key, deflate_bytes(raw), resolution_m, revision, utime_us);
}

Tile cloud_tile_of_packed(const TileKey& key, std::vector<std::uint8_t> packed, double resolution_m,
                          std::int64_t revision, std::int64_t utime_us) {
  return tile_of_packed(TileEncoding::kCloud, key, std::move(packed), kCloudTileVoxels,
                        resolution_m, revision, utime_us);
}

ColouredPoint as_encoded(const TileKey& key, const ColouredPoint& point, double resolution_m) {
  const double edge_m = kCloudTileVoxels * resolution_m;
  ColouredPoint encoded = point;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int32_t index = indices(key)[static_cast<std::size_t>(axis)];
    encoded.p_m[axis] = centre_of(units_of(point.p_m[axis], edge_m, index), edge_m, index);
  }
  return encoded;
}

void thin_to_tile(std::vector<ColouredPoint>* points) {
  if (points->size() <= kCloudTileMaxPoints) return;
  for (std::size_t i = 0; i < kCloudTileMaxPoints; ++i)
    (*points)[i] = (*points)[kept(i, points->size(), kCloudTileMaxPoints)];
  points->resize(kCloudTileMaxPoints);
}

std::optional<std::vector<ColouredPoint>> decode_cloud_tile(const Tile& tile) {
  if (tile.size_cells != kCloudTileVoxels) return std::nullopt;
  if (tile.encoding == TileEncoding::kEmpty) return std::vector<ColouredPoint>{};
  if (tile.encoding != TileEncoding::kCloud) return std::nullopt;
  if (!(tile.resolution_m > 0.0 && tile.resolution_m <= kMaxResolutionM)) return std::nullopt;
  const auto raw =
      inflate_bytes(tile.data.data(), tile.data.size(), kCloudTileMaxPoints * kPointBytes);
  if (!raw || raw->empty() || raw->size() % kPointBytes != 0) return std::nullopt;
  const std::size_t n = raw->size() / kPointBytes;
  const double edge_m = kCloudTileVoxels * tile.resolution_m;
  std::vector<ColouredPoint> points(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t at = 2 * (axis * n + i);
      const double units = (*raw)[at] + 256.0 * (*raw)[at + 1];
      points[i].p_m[static_cast<Eigen::Index>(axis)] =
          centre_of(units, edge_m, indices(tile.key)[axis]);
    }
    points[i].r = (*raw)[6 * n + i];
    points[i].g = (*raw)[7 * n + i];
    points[i].b = (*raw)[8 * n + i];
  }
  return points;
}

}  // namespace fusion_slam
