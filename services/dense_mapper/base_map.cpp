#include "services/dense_mapper/base_map.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr std::size_t kMostHot = 256;  // 8 MB: more than one submap touches

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
    cube_at(&hot_, index) = sum;
  }
  add_points(unpack_cloud(submap.packed_cloud, cloud_resolution_m_), submap.T_map_submap, nullptr);
}

void BaseMap::rebuild(const std::set<CubeIndex>& cubes, const DenseSubmaps& submaps,
                      std::int64_t upto) {
  VoxelCubes sums;
  std::set<TileKey> tiles;
  for (const CubeIndex& index : cubes) {
    cube_at(&sums, index);
    for (const TileKey& key : cloud_tiles_of(index)) {
      tiles.insert(key);
      clouds_.erase(key);
    }
  }
  for (const auto& [id, submap] : submaps) {
    if (id >= upto || !submap.closed) continue;
    std::vector<CubeIndex> wanted;
    for (const CubeIndex& index : submap.touches)
      if (cubes.count(index) != 0) wanted.push_back(index);
    if (wanted.empty()) continue;
    const VoxelCubes voxels = unpack_cubes(submap.packed);
    const SE3 T_submap_map = submap.T_map_submap.inverse();
    for (const CubeIndex& index : wanted)
      add_submap(voxels, T_submap_map, index, resolution_m_, bounds_, SliceRange{},
                 sums.at(index).get());
    add_points(unpack_cloud(submap.packed_cloud, cloud_resolution_m_), submap.T_map_submap, &tiles);
  }
  for (auto& [index, cells] : sums) {
    PackedBytes bytes = pack_cells(*cells);
    bytes.shrink_to_fit();
    if (bytes.empty())
      cubes_.erase(index);
    else
      cubes_[index] = std::move(bytes);
  }
  hot_.clear();
}

void BaseMap::add_points(const std::vector<ColouredPoint>& points_submap, const SE3& T_map_submap,
                         const std::set<TileKey>* only) {
  std::map<TileKey, std::vector<ColouredPoint>> by_tile;
  for (ColouredPoint point : points_submap) {
    const Eigen::Vector3d p_map = T_map_submap * point.p_m.cast<double>();
    const TileKey key = cloud_tile_of(0, p_map, cloud_resolution_m_);
    if (only != nullptr && only->count(key) == 0) continue;
    point.p_m = p_map.cast<float>();
    by_tile[key].push_back(point);
  }
  for (const auto& [key, fresh] : by_tile) {
    std::vector<ColouredPoint> all = points(key);
    std::bitset<kOctomapTileVolume> taken;
    for (const ColouredPoint& point : all)
      taken.set(cloud_voxel_of(key, point.p_m.cast<double>(), cloud_resolution_m_));
    const std::size_t before = all.size();
    for (const ColouredPoint& point : fresh) {
      const std::size_t voxel = cloud_voxel_of(key, point.p_m.cast<double>(), cloud_resolution_m_);
      if (taken.test(voxel)) continue;
      taken.set(voxel);
      all.push_back(point);
    }
    if (all.size() == before) continue;
    PackedBytes bytes = encode_cloud_tile(key, all, cloud_resolution_m_, 0, 0).data;
    bytes.shrink_to_fit();
    clouds_[key] = std::move(bytes);
  }
}

std::vector<ColouredPoint> BaseMap::points(const TileKey& key) const {
  const auto it = clouds_.find(key);
  if (it == clouds_.end()) return {};
  return unpack_cloud({*it}, cloud_resolution_m_);
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
