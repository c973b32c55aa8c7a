#include "libs/octree/octomap_tile.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr std::size_t kMaskBytes = kOctomapTileVolume / 8;

}  // namespace

std::int8_t log_odds_to_step(double log_odds) {
  const double step = std::round(log_odds / kLogOddsStep);
  return static_cast<std::int8_t>(std::clamp(step, -127.0, 127.0));
}

Tile encode_octomap_tile(const TileKey& key, const VoxelCells& cells, double resolution_m,
                         std::int64_t revision, std::int64_t utime_us) {
  std::vector<std::uint8_t> raw(kMaskBytes, 0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] == kUnknownVoxel) continue;
    raw[i / 8] = static_cast<std::uint8_t>(raw[i / 8] | (1U << (i % 8)));
    raw.push_back(static_cast<std::uint8_t>(cells[i]));
  }
  Tile tile;
  tile.key = key;
  tile.utime_us = utime_us;
  tile.revision = revision;
  tile.resolution_m = resolution_m;
  tile.size_cells = kOctomapTileVoxels;
  if (raw.size() == kMaskBytes) return tile;
  tile.encoding = TileEncoding::kOctomap;
  tile.data = deflate_bytes(raw);
  return tile;
}

std::optional<VoxelCells> decode_octomap_cells(const Tile& tile) {
  if (tile.size_cells != kOctomapTileVoxels) return std::nullopt;
  VoxelCells cells;
  cells.fill(kUnknownVoxel);
  if (tile.encoding == TileEncoding::kEmpty) return cells;
  if (tile.encoding != TileEncoding::kOctomap) return std::nullopt;
  const auto raw =
      inflate_bytes(tile.data.data(), tile.data.size(), kMaskBytes + kOctomapTileVolume);
  if (!raw || raw->size() < kMaskBytes) return std::nullopt;
  std::size_t next = kMaskBytes;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (((*raw)[i / 8] >> (i % 8) & 1U) == 0) continue;
    if (next == raw->size()) return std::nullopt;
    cells[i] = static_cast<std::int8_t>((*raw)[next++]);
    if (cells[i] == kUnknownVoxel) return std::nullopt;
  }
  if (next != raw->size()) return std::nullopt;
  return cells;
}

std::optional<std::vector<OctomapVoxel>> decode_octomap_tile(const Tile& tile) {
  const auto cells = decode_octomap_cells(tile);
  if (!cells) return std::nullopt;
  std::vector<OctomapVoxel> voxels;
  for (std::size_t i = 0; i < cells->size(); ++i) {
    const std::int8_t step = (*cells)[i];
    if (step == kUnknownVoxel) continue;
    OctomapVoxel voxel;
    voxel.x = static_cast<std::uint8_t>(i % kOctomapTileVoxels);
    voxel.y = static_cast<std::uint8_t>(i / kOctomapTileVoxels % kOctomapTileVoxels);
    voxel.z = static_cast<std::uint8_t>(i / (kOctomapTileVoxels * kOctomapTileVoxels));
    voxel.log_odds = static_cast<float>(step * kLogOddsStep);
    voxels.push_back(voxel);
  }
  return voxels;
}

Eigen::Vector3d voxel_centre_m(const Tile& tile, const OctomapVoxel& voxel) {
  const Eigen::Vector3d corner(tile.key.x, tile.key.y, tile.key.z);
  const Eigen::Vector3d centre(voxel.x + 0.5, voxel.y + 0.5, voxel.z + 0.5);
  return (corner * kOctomapTileVoxels + centre) * tile.resolution_m;
}

}  // namespace fusion_slam
