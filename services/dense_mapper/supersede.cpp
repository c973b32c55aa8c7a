#include "services/dense_mapper/supersede.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

bool overlap(const std::vector<CubeIndex>& a, const std::vector<CubeIndex>& b) {
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() && j != b.end()) {
    if (*i == *j) return true;
    if (*i < *j)
      ++i;
    else
      ++j;
  }
  return false;
}

constexpr int kMostVisits = 6;  // what is left after each is asked for half as often

// Counts, for each voxel of a cube, the submaps that know it: at most `most`.
using Counts = std::array<std::uint8_t, kOctomapTileVolume>;

CubeIndex cube_at_point(const Eigen::Vector3d& p_m, double resolution_m) {
  const Eigen::Array3i voxel = (p_m / resolution_m).array().floor().cast<int>();
  return {voxel.x() >> 5, voxel.y() >> 5, voxel.z() >> 5};
}

}  // namespace

std::int64_t count_newer(std::int64_t closed_id, int enough, DenseSubmaps* submaps) {
  const DenseSubmap& closed = submaps->at(closed_id);
  std::int64_t chosen = 0;
  int fewest_visits = kMostVisits + 1;
  int most = 0;
  for (auto& [id, submap] : *submaps) {
    if (id >= closed_id) break;
    if (!submap.closed || submap.packed.empty() || !overlap(submap.touches, closed.touches))
      continue;
    ++submap.newer;
    const int visits = std::min(submap.visits, kMostVisits);
    if (submap.newer < enough << visits) continue;
    if (visits > fewest_visits || (visits == fewest_visits && submap.newer <= most)) continue;
    fewest_visits = visits;
    most = submap.newer;
    chosen = id;
  }
  return chosen;
}

bool drop_superseded(std::int64_t id, int keep, double resolution_m, double cloud_resolution_m,
                     DenseSubmaps* submaps) {
  DenseSubmap& old = submaps->at(id);
  old.newer = 0;
  ++old.visits;
  std::map<CubeIndex, Counts> counts;
  for (const auto& [index, bytes] : old.packed) counts[index].fill(0);
  // The newest first: they suffice almost everywhere.
  for (auto it = submaps->rbegin(); it != submaps->rend() && it->first > id; ++it) {
    const DenseSubmap& newer = it->second;
    if (!newer.closed || !overlap(newer.touches, old.touches)) continue;
    const VoxelCubes voxels = unpack_cubes(newer.packed);
    const SE3 T_newer_old = newer.T_map_submap.inverse() * old.T_map_submap;
    VoxelCells known;
    for (auto& [index, count] : counts) {
      known.fill(kUnknownVoxel);
      if (!add_submap(voxels, T_newer_old, index, resolution_m, {-127, 127}, SliceRange{}, &known))
        continue;
      for (std::size_t i = 0; i < known.size(); ++i)
        if (known[i] != kUnknownVoxel && count[i] < keep) ++count[i];
    }
  }
  PackedCubes packed;
  std::size_t dropped = 0;
  VoxelCells cells;
  for (const auto& [index, bytes] : old.packed) {
    unpack_cells(bytes, &cells);
    const Counts& count = counts.at(index);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i] == kUnknownVoxel || count[i] < keep) continue;
      cells[i] = kUnknownVoxel;
      ++dropped;
    }
    PackedBytes left = pack_cells(cells);
    left.shrink_to_fit();
    if (!left.empty()) packed.emplace(index, std::move(left));
  }
  if (dropped == 0) return false;
  std::vector<ColouredPoint> points = unpack_cloud(old.packed_cloud, cloud_resolution_m);
  points.erase(
      std::remove_if(points.begin(), points.end(),
                     [&](const ColouredPoint& point) {
                       const Eigen::Vector3d p_m = point.p_m.cast<double>();
                       const auto it = counts.find(cube_at_point(p_m, resolution_m));
                       if (it == counts.end()) return false;
                       const Eigen::Array3i v = (p_m / resolution_m).array().floor().cast<int>();
                       return it->second[voxel_index(v.x() & 31, v.y() & 31, v.z() & 31)] >= keep;
                     }),
      points.end());
  old.packed = std::move(packed);
  old.packed_cloud = pack_cloud(points, cloud_resolution_m);
  const std::set<CubeIndex> touched = touched_cubes(old, resolution_m);
  old.touches.assign(touched.begin(), touched.end());
  return old.packed.empty();
}

}  // namespace fusion_slam
