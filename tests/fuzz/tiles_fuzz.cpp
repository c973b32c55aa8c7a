// link: fs_grid fs_octree fs_cloud
// Tiles of every encoding whose data are any bytes, as they are and deflated, so that the decoders
// behind zlib are reached too. What a decoder takes, the encoder gives back.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "libs/cloud/cloud_tile.hpp"
#include "libs/grid/fused_tile.hpp"
#include "libs/octree/octomap_tile.hpp"
#include "tests/fuzz/allocations.hpp"

namespace {

using Bytes = std::vector<std::uint8_t>;

void require(bool ok) {
  if (!ok) std::abort();
}

void try_inflate(const Bytes& data) {
  for (const std::size_t most : {std::size_t{0}, std::size_t{1}, std::size_t{5000}}) {
    const std::size_t before = fusion_slam::allocated_bytes();
    const auto raw = fusion_slam::inflate_bytes(data.data(), data.size(), most);
    require(fusion_slam::allocated_bytes() - before <= 65536 + 4 * most);
    require(!raw || raw->size() <= most);
  }
  const Bytes deflated = fusion_slam::deflate_bytes(data);
  const auto back = fusion_slam::inflate_bytes(deflated.data(), deflated.size(), data.size());
  require(back && *back == data);
}

void try_tile(const fusion_slam::Tile& t) {
  if (const auto cells = fusion_slam::decode_grid_tile(t)) {
    const auto again = fusion_slam::encode_grid_tile(t.key, *cells, t.resolution_m, 0, 0);
    require(fusion_slam::decode_grid_tile(again) == cells);
  }
  if (const auto cells = fusion_slam::decode_fused_tile(t)) {
    const auto again = fusion_slam::encode_fused_tile(t.key, *cells, t.resolution_m, 0, 0);
    require(fusion_slam::decode_fused_tile(again) == cells);
  }
  const auto voxels = fusion_slam::decode_octomap_tile(t);
  if (const auto cells = fusion_slam::decode_octomap_cells(t)) {
    const auto again = fusion_slam::encode_octomap_tile(t.key, *cells, t.resolution_m, 0, 0);
    require(fusion_slam::decode_octomap_cells(again) == cells);
    require(voxels && voxels->size() <= fusion_slam::kOctomapTileVolume);
    for (const auto& voxel : *voxels) {
      require(std::abs(voxel.log_odds) < 4.0F);
      fusion_slam::voxel_centre_m(t, voxel);
    }
  } else {
    require(!voxels);
  }
  if (const auto points = fusion_slam::decode_cloud_tile(t)) {
    require(points->size() <= fusion_slam::kCloudTileMaxPoints);
    for (const auto& point : *points) require(point.p_m.allFinite());
    fusion_slam::encode_cloud_tile(t.key, *points, t.resolution_m, 0, 0);
  }
}

}  // namespace

// 32 bytes say what the tile claims to be; the rest is its data.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fusion_slam::count_allocations();
  if (size < 32) return 0;
  fusion_slam::Tile tile;
  std::memcpy(&tile.key.x, data, 4);
  std::memcpy(&tile.key.y, data + 4, 4);
  std::memcpy(&tile.key.z, data + 8, 4);
  if (data[12] % 2 == 1) std::memcpy(&tile.resolution_m, data + 16, 8);
  tile.encoding = static_cast<fusion_slam::TileEncoding>(data[13] % 6);
  const bool grid = data[13] % 6 == 1 || data[13] % 6 == 2;
  tile.size_cells = data[14] == 0xFF ? data[15] : (grid ? 64 : 32);
  const Bytes rest(data + 32, data + size);
  try_inflate(rest);
  tile.data = rest;
  try_tile(tile);
  // Repeated to a length that an encoding may have.
  const std::size_t lengths[] = {rest.size(), 4096, 8192, 4096 + rest.size(),
                                 9 * (data[24] + 256U * data[25])};
  Bytes raw(lengths[data[26] % 5]);
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = rest.empty() ? 0 : rest[i % rest.size()];
  if (data[26] % 5 == 3) {  // a mask of as many voxels as there are steps
    std::fill(raw.begin(), raw.begin() + 4096, 0);
    for (std::size_t i = 0; i < rest.size(); ++i)
      raw[i / 8] = static_cast<std::uint8_t>(raw[i / 8] | 1U << i % 8);
    std::copy(rest.begin(), rest.end(), raw.begin() + 4096);
  }
  tile.data = fusion_slam::deflate_bytes(raw);
  try_tile(tile);
  return 0;
}
