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

constexpr int kEdge = kOctomapTileVoxels;
// So that it takes as long after hours: who is known to fewer than 4 of so many stays until next.
constexpr int kMostLookedAt = 128;
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

// A voxel of which too few newer submaps are known to know it: its centre in voxels of the old one.
struct Voxel {
  Eigen::Vector3d centre;
  std::uint8_t* count;
};
using Undecided = std::map<CubeIndex, std::vector<Voxel>>;  // by cube of the old submap

Undecided undecided_of(std::map<CubeIndex, Counts>* counts) {
  Undecided undecided;
  for (auto& [index, count] : *counts) {
    const Eigen::Vector3d corner =
        Eigen::Vector3d(index.x, index.y, index.z) * kEdge + Eigen::Vector3d::Constant(0.5);
    std::vector<Voxel> voxels;
    for (std::size_t i = 0; i < count.size(); ++i)
      if (count[i] == 0)
        voxels.push_back(
            {corner + Eigen::Array3i(static_cast<int>(i & 31), static_cast<int>(i >> 5 & 31),
                                     static_cast<int>(i >> 10))
                          .cast<double>()
                          .matrix(),
             &count[i]});
    if (!voxels.empty()) undecided.emplace(index, std::move(voxels));
  }
  return undecided;
}

// A submap's cubes, unpacked when they are asked for.
class Cubes {
 public:
  explicit Cubes(const PackedCubes& packed) : packed_(packed) {}
  // Null when there is none.
  const VoxelCells* at(const CubeIndex& index) {
    if (asked_ && index == last_) return cells_;
    asked_ = true;
    last_ = index;
    cells_ = nullptr;
    const auto packed = packed_.find(index);
    if (packed == packed_.end()) return nullptr;
    const bool fresh = unpacked_.count(index) == 0;
    VoxelCells& cells = cube_at(&unpacked_, index);
    if (fresh) unpack_cells(packed->second, &cells);
    return cells_ = &cells;
  }
  bool any_of(const std::set<CubeIndex>& some) const {
    return std::any_of(some.begin(), some.end(),
                       [this](const CubeIndex& index) { return packed_.count(index) != 0; });
  }

 private:
  const PackedCubes& packed_;
  VoxelCubes unpacked_;
  bool asked_ = false;
  CubeIndex last_;
  const VoxelCells* cells_ = nullptr;
};

// Counts what this newer submap knows, and forgets the voxels that enough know by now.
void count_known(const DenseSubmap& newer, const SE3& T_newer_old, double resolution_m, int keep,
                 Undecided* undecided) {
  constexpr int kFar = 1 << 20;  // whole cubes; rounding down is by cutting off then
  SE3 T = T_newer_old;           // in voxels
  T.translation() /= resolution_m;
  const Eigen::Matrix3d R = T.linear();
  const Eigen::Vector3d t = T.translation() + Eigen::Vector3d::Constant(kFar);
  Cubes cubes(newer.packed);
  for (auto it = undecided->begin(); it != undecided->end();) {
    auto& [index, voxels] = *it;
    const Eigen::Vector3d low = Eigen::Vector3d(index.x, index.y, index.z) * kEdge;
    std::set<CubeIndex> touched;
    insert_touched(low, low + Eigen::Vector3d::Constant(kEdge), T, kEdge, &touched);
    if (!cubes.any_of(touched)) {
      ++it;
      continue;
    }
    for (const Voxel& voxel : voxels) {
      const Eigen::Array3i v = (R * voxel.centre + t).array().cast<int>() - kFar;
      const VoxelCells* cells = cubes.at({v.x() >> 5, v.y() >> 5, v.z() >> 5});
      if (cells != nullptr &&
          (*cells)[voxel_index(v.x() & 31, v.y() & 31, v.z() & 31)] != kUnknownVoxel)
        ++*voxel.count;
    }
    const auto decided = [keep](const Voxel& voxel) { return *voxel.count >= keep; };
    voxels.erase(std::remove_if(voxels.begin(), voxels.end(), decided), voxels.end());
    it = voxels.empty() ? undecided->erase(it) : std::next(it);
  }
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
  Undecided undecided = undecided_of(&counts);
  // The newest first: they suffice almost everywhere.
  int looked_at = 0;
  for (auto it = submaps->rbegin(); it != submaps->rend() && it->first > id; ++it) {
    const DenseSubmap& newer = it->second;
    if (undecided.empty() || looked_at == kMostLookedAt) break;
    if (!newer.closed || !overlap(newer.touches, old.touches)) continue;
    count_known(newer, newer.T_map_submap.inverse() * old.T_map_submap, resolution_m, keep,
                &undecided);
    ++looked_at;
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
