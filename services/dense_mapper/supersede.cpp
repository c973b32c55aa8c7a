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

// Of the voxel that a point is in; null outside.
std::uint8_t* count_at(const ColouredPoint& point, double resolution_m,
                       std::map<CubeIndex, Counts>* counts) {
  const Eigen::Array3i v = (point.p_m.cast<double>() / resolution_m).array().floor().cast<int>();
  const auto it = counts->find({v.x() >> 5, v.y() >> 5, v.z() >> 5});
  if (it == counts->end()) return nullptr;
  return &it->second[voxel_index(v.x() & 31, v.y() & 31, v.z() & 31)];
}

}  // namespace

std::int64_t count_newer(std::int64_t closed_id, int enough, DenseSubmaps* submaps,
                         std::set<std::int64_t>* counted) {
  const DenseSubmap& closed = submaps->at(closed_id);
  std::int64_t chosen = 0;
  int fewest_visits = kMostVisits + 1;
  int most = 0;
  for (auto& [id, submap] : *submaps) {
    if (id >= closed_id) break;
    if (!submap.closed || submap.packed.empty() || !overlap(submap.touches, closed.touches))
      continue;
    ++submap.newer;
    counted->insert(id);
    const int visits = std::min(submap.visits, kMostVisits);
    if (submap.newer < enough << visits) continue;
    if (visits > fewest_visits || (visits == fewest_visits && submap.newer <= most)) continue;
    fewest_visits = visits;
    most = submap.newer;
    chosen = id;
  }
  return chosen;
}

std::int64_t ripest(int enough, const DenseSubmaps& submaps) {
  std::int64_t chosen = 0;
  double most = 0.0;
  for (const auto& [id, submap] : submaps) {
    if (!submap.closed || submap.packed.empty() || submap.newer < enough) continue;
    const double gain =
        static_cast<double>(size_bytes(submap)) * submap.newer / (1.0 + submap.visits);
    if (gain <= most) continue;
    most = gain;
    chosen = id;
  }
  return chosen;
}

bool drop_superseded(std::int64_t id, int keep, double resolution_m, double cloud_resolution_m,
                     DenseSubmaps* submaps) {
  DenseSubmap& old = submaps->at(id);
  old.newer = 0;
  ++old.visits;
  std::vector<ColouredPoint> points = unpack_cloud(old.packed_cloud, cloud_resolution_m);
  std::map<CubeIndex, Counts> counts;
  VoxelCells cells;
  for (const auto& [index, bytes] : old.packed) {  // a voxel that it doesn't know needs no count
    unpack_cells(bytes, &cells);
    Counts& count = counts[index];
    for (std::size_t i = 0; i < cells.size(); ++i)
      count[i] = cells[i] == kUnknownVoxel ? static_cast<std::uint8_t>(keep) : 0;
  }
  for (const ColouredPoint& point : points)  // except for the points in it
    if (std::uint8_t* count = count_at(point, resolution_m, &counts)) *count = 0;
  std::map<CubeIndex, std::ptrdiff_t> open;  // voxels of each cube that too few newer ones know
  std::set<CubeIndex> undecided;
  for (const auto& [index, count] : counts) {
    open[index] = std::count(count.begin(), count.end(), 0);
    if (open[index] > 0) undecided.insert(index);
  }
  // The newest first: they suffice almost everywhere.
  for (auto it = submaps->rbegin(); it != submaps->rend() && it->first > id; ++it) {
    const DenseSubmap& newer = it->second;
    if (undecided.empty()) break;
    if (!newer.closed || !overlap(newer.touches, old.touches)) continue;
    const SE3 T_newer_old = newer.T_map_submap.inverse() * old.T_map_submap;
    const VoxelCubes voxels =
        unpack_touching(newer.packed, T_newer_old.inverse(), resolution_m, undecided);
    VoxelCells known;
    for (auto index = undecided.begin(); index != undecided.end();) {
      known.fill(kUnknownVoxel);
      std::ptrdiff_t& left = open.at(*index);
      if (add_submap(voxels, T_newer_old, *index, resolution_m, {-127, 127}, SliceRange{},
                     &known)) {
        Counts& count = counts.at(*index);
        for (std::size_t i = 0; i < known.size(); ++i)
          if (known[i] != kUnknownVoxel && count[i] < keep && ++count[i] == keep) --left;
      }
      index = left == 0 ? undecided.erase(index) : std::next(index);
    }
  }
  PackedCubes packed;
  std::size_t dropped = 0;
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
  points.erase(std::remove_if(points.begin(), points.end(),
                              [&](const ColouredPoint& point) {
                                const std::uint8_t* count = count_at(point, resolution_m, &counts);
                                return count != nullptr && *count >= keep;
                              }),
               points.end());
  old.packed = std::move(packed);
  old.packed_cloud = pack_cloud(points, cloud_resolution_m);
  const std::set<CubeIndex> touched = touched_cubes(old, resolution_m);
  old.touches.assign(touched.begin(), touched.end());
  return old.packed.empty();
}

}  // namespace fusion_slam
