#include "services/dense_mapper/base_map.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr std::size_t kMostHot = 256;         // 8 MB: more than one submap touches
constexpr std::size_t kMostHotClouds = 1024;  // some 8 MB

// Points of a submap that may lie in tiles of the map.
std::vector<ColouredPoint> points_touching(const DenseSubmap& submap, double cloud_resolution_m,
                                           const std::set<TileKey>& tiles) {
  const double edge_m = kCloudTileVoxels * cloud_resolution_m;
  const Eigen::Vector3d slack_m = Eigen::Vector3d::Constant(1e-3);
  std::vector<ColouredPoint> points;
  for (const auto& packed : submap.packed_cloud) {
    const Eigen::Vector3d low_m =
        Eigen::Vector3d(packed.first.x, packed.first.y, packed.first.z) * edge_m;
    std::set<CubeIndex> touched;
    insert_touched(low_m - slack_m, low_m + Eigen::Vector3d::Constant(edge_m) + slack_m,
                   submap.T_map_submap, edge_m, &touched);
    const bool near = std::any_of(touched.begin(), touched.end(), [&](const CubeIndex& cube) {
      return tiles.count({0, cube.x, cube.y, cube.z}) != 0;
    });
    if (!near) continue;
    const std::vector<ColouredPoint> some = unpack_cloud({packed}, cloud_resolution_m);
    points.insert(points.end(), some.begin(), some.end());
  }
  return points;
}

}  // namespace

BaseMap::BaseMap(double resolution_m, double cloud_resolution_m, const StepBounds& bounds)
    : resolution_m_(resolution_m), cloud_resolution_m_(cloud_resolution_m), bounds_(bounds) {}

const VoxelCells& BaseMap::cells(const CubeIndex& index) {
  const auto hot = hot_.find(index);
  if (hot != hot_.end()) return *hot->second;
  if (hot_.size() >= kMostHot) hot_.clear();
  VoxelCells& cells = cube_at(&hot_, index);
  const auto packed = cubes_.find(index);
  if (packed != cubes_.end()) unpack_cells(packed->second, &cells);
  return cells;
}

void BaseMap::extend(const DenseSubmap& submap) {
  const VoxelCubes voxels = unpack_cubes(submap.packed);
  const SE3 T_submap_map = submap.T_map_submap.inverse();
  for (const CubeIndex& index : submap.touches) {
    VoxelCells sum = cells(index);
    if (!add_submap(voxels, T_submap_map, index, resolution_m_, bounds_, SliceRange{}, &sum))
      continue;
    PackedBytes bytes = pack_cells(sum);
    if (bytes.empty()) continue;
    bytes.shrink_to_fit();
    cubes_[index] = std::move(bytes);
    changed_cubes_.insert(index);
    cube_at(&hot_, index) = sum;
  }
  OpenTiles tiles;
  add_points(unpack_cloud(submap.packed_cloud, cloud_resolution_m_), submap.T_map_submap, nullptr,
             &tiles);
  pack(&tiles);
}

void BaseMap::rebuild_cells(const std::set<CubeIndex>& cubes, const DenseSubmaps& submaps,
                            std::int64_t upto) {
  VoxelCubes sums;
  for (const CubeIndex& index : cubes) cube_at(&sums, index);
  for (const auto& [id, submap] : submaps) {
    if (id >= upto || !submap.closed) continue;
    std::vector<CubeIndex> wanted;
    for (const CubeIndex& index : submap.touches)
      if (cubes.count(index) != 0) wanted.push_back(index);
    if (wanted.empty()) continue;
    const VoxelCubes voxels =
        unpack_touching(submap.packed, submap.T_map_submap, resolution_m_, cubes);
    const SE3 T_submap_map = submap.T_map_submap.inverse();
    for (const CubeIndex& index : wanted)
      add_submap(voxels, T_submap_map, index, resolution_m_, bounds_, SliceRange{},
                 sums.at(index).get());
  }
  for (auto& [index, cells] : sums) {
    PackedBytes bytes = pack_cells(*cells);
    bytes.shrink_to_fit();
    changed_cubes_.insert(index);
    if (bytes.empty())
      cubes_.erase(index);
    else
      cubes_[index] = std::move(bytes);
    hot_.erase(index);
  }
}

void BaseMap::rebuild_points(const std::set<CubeIndex>& cubes, const DenseSubmaps& submaps,
                             std::int64_t upto) {
  std::set<TileKey> tiles;
  for (const CubeIndex& index : cubes)
    for (const TileKey& key : cloud_tiles_of(index)) {
      tiles.insert(key);
      changed_clouds_.insert(key);
      clouds_.erase(key);
      hot_clouds_.erase(key);
    }
  OpenTiles open_tiles;
  for (const auto& [id, submap] : submaps) {
    if (id >= upto || !submap.closed) continue;
    if (std::any_of(submap.touches.begin(), submap.touches.end(),
                    [&cubes](const CubeIndex& index) { return cubes.count(index) != 0; }))
      add_points(points_touching(submap, cloud_resolution_m_, tiles), submap.T_map_submap, &tiles,
                 &open_tiles);
  }
  pack(&open_tiles);
}

BaseMap::OpenTile& BaseMap::open(const TileKey& key, OpenTiles* tiles) const {
  const auto [it, fresh] = tiles->try_emplace(key);
  OpenTile& tile = it->second;
  if (!fresh) return tile;
  tile.points = points(key);
  for (const ColouredPoint& point : tile.points)
    tile.taken.set(cloud_voxel_of(key, point.p_m.cast<double>(), cloud_resolution_m_));
  return tile;
}

void BaseMap::add_points(const std::vector<ColouredPoint>& points_submap, const SE3& T_map_submap,
                         const std::set<TileKey>* only, OpenTiles* tiles) const {
  for (ColouredPoint point : points_submap) {
    const Eigen::Vector3d p_map = T_map_submap * point.p_m.cast<double>();
    const TileKey key = cloud_tile_of(0, p_map, cloud_resolution_m_);
    if (only != nullptr && only->count(key) == 0) continue;
    point.p_m = p_map.cast<float>();
    OpenTile& tile = open(key, tiles);
    const std::size_t voxel = cloud_voxel_of(key, point.p_m.cast<double>(), cloud_resolution_m_);
    if (tile.taken.test(voxel)) continue;
    tile.taken.set(voxel);
    tile.points.push_back(as_encoded(key, point, cloud_resolution_m_));
    tile.changed = true;
  }
  for (auto& [key, tile] : *tiles) {
    if (tile.points.size() <= kCloudTileMaxPoints) continue;
    thin_to_tile(&tile.points);
    tile.taken.reset();
    for (const ColouredPoint& point : tile.points)
      tile.taken.set(cloud_voxel_of(key, point.p_m.cast<double>(), cloud_resolution_m_));
  }
}

void BaseMap::pack(OpenTiles* tiles) {
  if (hot_clouds_.size() + tiles->size() > kMostHotClouds) hot_clouds_.clear();
  for (auto& [key, tile] : *tiles) {
    if (!tile.changed) continue;
    PackedBytes bytes = encode_cloud_tile(key, tile.points, cloud_resolution_m_, 0, 0).data;
    bytes.shrink_to_fit();
    clouds_[key] = std::move(bytes);
    hot_clouds_[key] = std::move(tile.points);
    changed_clouds_.insert(key);
  }
}

std::vector<ColouredPoint> BaseMap::points(const TileKey& key) const {
  const auto hot = hot_clouds_.find(key);
  if (hot != hot_clouds_.end()) return hot->second;
  const auto it = clouds_.find(key);
  if (it == clouds_.end()) return {};
  return unpack_cloud({*it}, cloud_resolution_m_);
}

void BaseMap::restore(PackedCubes cubes, PackedCloud clouds) {
  cubes_ = std::move(cubes);
  clouds_ = std::move(clouds);
  forget_unpacked();
}

std::size_t BaseMap::size_bytes() const {
  std::size_t sum = fusion_slam::size_bytes(cubes_);
  for (const auto& [key, bytes] : clouds_) sum += bytes.size();
  return sum;
}

std::size_t cloud_voxel_of(const TileKey& key, const Eigen::Vector3d& p_m, double resolution_m) {
  const auto within = [resolution_m](double p, std::int32_t tile) {
    const int voxel = static_cast<int>(std::floor(p / resolution_m)) - tile * kCloudTileVoxels;
    return std::clamp(voxel, 0, kCloudTileVoxels - 1);
  };
  return voxel_index(within(p_m.x(), key.x), within(p_m.y(), key.y), within(p_m.z(), key.z));
}

std::array<TileKey, 8> cloud_tiles_of(const CubeIndex& cube) {
  std::array<TileKey, 8> keys;
  for (int i = 0; i < 8; ++i)
    keys[static_cast<std::size_t>(i)] = {0, 2 * cube.x + (i & 1), 2 * cube.y + (i >> 1 & 1),
                                         2 * cube.z + (i >> 2 & 1)};
  return keys;
}

}  // namespace fusion_slam
