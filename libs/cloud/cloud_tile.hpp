// Tile of a coloured point cloud (encoding kCloud): the points in a cube of 32 x 32 x 32 voxels of
// resolution_m, at most kCloudTileMaxPoints. Byte table: docs/tiles.md.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "libs/tiles/tile.hpp"

namespace fusion_slam {

constexpr int kCloudTileVoxels = 32;
constexpr std::size_t kCloudTileMaxPoints =
    5400;  // 9 bytes a point: under 49 KB even if nothing compresses

struct ColouredPoint {
  Eigen::Vector3f p_m = Eigen::Vector3f::Zero();  // in the tile's frame (the map's for submap 0)
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
};

// Tile in which a point lies, of clouds with this voxel size.
TileKey cloud_tile_of(std::int64_t submap_id, const Eigen::Vector3d& p_m, double resolution_m);

// Points are kept to 1/65536 of the cube's edge; those outside the cube are moved to its face. More
// than the maximum are thinned evenly. No points make an empty tile (kEmpty). Decoding gives
// nothing when the tile is not what encode_cloud_tile makes; an empty tile decodes to no points.
// Never throws on any bytes.
Tile encode_cloud_tile(const TileKey& key, const std::vector<ColouredPoint>& points,
                       double resolution_m, std::int64_t revision, std::int64_t utime_us);
std::optional<std::vector<ColouredPoint>> decode_cloud_tile(const Tile& tile);
// The same from what encode_cloud_tile() packed (Tile::data); no bytes make an empty tile.
Tile cloud_tile_of_packed(const TileKey& key, std::vector<std::uint8_t> packed, double resolution_m,
                          std::int64_t revision, std::int64_t utime_us);

// What a point, or too many of them, would be once encoded and decoded.
ColouredPoint as_encoded(const TileKey& key, const ColouredPoint& point, double resolution_m);
void thin_to_tile(std::vector<ColouredPoint>* points);

}  // namespace fusion_slam
