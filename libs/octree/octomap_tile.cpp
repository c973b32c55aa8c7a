#include "libs/octree/octomap_tile.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libs/octree/voxel_pack.hpp"
#include "libs/tiles/packed_tile.hpp"

namespace fusion_slam {
std::int8_t log_odds_to_step(double log_odds) {
  const double step = std::round(log_odds / kLogOddsStep);
  return static_cast<std::int8_t>(std::clamp(step, -127.0, 127.0));
}

Tile encode_octomap_tile(const TileKey& key, const VoxelCells& cells, double resolution_m,
                         std::int64_t revision, std::int64_t utime_us) {
  return octomap_tile_of(key, pack_cells(cells), resolution_m, revision, utime_us);
}

Tile octomap_tile_of(const TileKey& key, std::vector<std::uint8_t> packed, double resolution_m,
                     std::int64_t revision, std::int64_t utime_us) {
  return tile_of_packed(TileEncoding::kOctomap, key, std::move(packed), kOctomapTileVoxels,
                        resolution_m, revision, utime_us);
}

std::optional<VoxelCells> decode_octomap_cells(const Tile& tile) {
  if (tile.size_cells != kOctomapTileVoxels) return std::nullopt;
  VoxelCells cells;
  cells.fill(kUnknownVoxel);
  if (tile.encoding == TileEncoding::kEmpty) return cells;
  if (tile.encoding != TileEncoding::kOctomap || tile.data.empty()) return std::nullopt;
  if (!unpack_cells(tile.data, &cells)) return std::nullopt;
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
