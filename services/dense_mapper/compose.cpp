#include "services/dense_mapper/compose.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr int kShift = 16;  // coordinates in voxels, fixed point: exact to 1/65536 of a voxel
constexpr double kOne = 1 << kShift;
// A cube's corners are at most sqrt(3) edges apart: 3 cubes of a submap along each axis.
constexpr int kSpan = 4;

struct Fixed {
  std::int32_t x, y, z;
};
Fixed fixed(const Eigen::Vector3d& p) {
  return {static_cast<std::int32_t>(std::lround(p.x() * kOne)),
          static_cast<std::int32_t>(std::lround(p.y() * kOne)),
          static_cast<std::int32_t>(std::lround(p.z() * kOne))};
}

// The submap's cubes that a cube of the map can touch, side by side.
struct Neighbourhood {
  CubeIndex low;
  std::array<const VoxelCells*, kSpan * kSpan * kSpan> cubes{};
  bool any = false;
};

Neighbourhood neighbourhood(const VoxelCubes& submap, const Eigen::Vector3d& low_voxel,
                            const Eigen::Vector3d& high_voxel) {
  Neighbourhood around;
  const Eigen::Array3i low = (low_voxel / kOctomapTileVoxels).array().floor().cast<int>();
  const Eigen::Array3i high = (high_voxel / kOctomapTileVoxels).array().floor().cast<int>();
  around.low = {low.x(), low.y(), low.z()};
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) {
        const auto it = submap.find({x, y, z});
        if (it == submap.end()) continue;
        const int at = ((z - low.z()) * kSpan + y - low.y()) * kSpan + x - low.x();
        around.cubes[static_cast<std::size_t>(at)] = it->second.get();
        around.any = true;
      }
  return around;
}

}  // namespace

bool add_submap(const VoxelCubes& submap, const SE3& T_submap_map, const CubeIndex& index,
                double resolution_m, const StepBounds& bounds, const SliceRange& slices,
                VoxelCells* sum) {
  // In voxels of the submap: the first centre, and the way from one to the next along each axis.
  const Eigen::Vector3d corner = Eigen::Vector3d(index.x, index.y, index.z) * kOctomapTileVoxels +
                                 Eigen::Vector3d::Constant(0.5);
  const Eigen::Matrix3d axes = T_submap_map.linear();
  const Eigen::Vector3d first = axes * corner + T_submap_map.translation() / resolution_m;
  const double last = kOctomapTileVoxels - 1;
  const Eigen::Vector3d from = first + axes.col(2) * slices.from;
  const Eigen::Vector3d edge_z = axes.col(2) * (slices.to - 1 - slices.from);
  Eigen::Vector3d low = from;
  Eigen::Vector3d high = from;
  for (int i = 1; i < 8; ++i) {
    const Eigen::Vector3d p = from + axes.col(0) * ((i & 1) != 0 ? last : 0.0) +
                              axes.col(1) * ((i & 2) != 0 ? last : 0.0) +
                              ((i & 4) != 0 ? edge_z : Eigen::Vector3d::Zero());
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  low.array() -= 0.01;  // rounding to fixed point
  high.array() += 0.01;
  if (!(low.array().abs() < 30000.0).all() || !(high.array().abs() < 30000.0).all()) return false;
  const Neighbourhood around = neighbourhood(submap, low, high);
  if (!around.any) return false;
  const Eigen::Vector3d origin =
      Eigen::Vector3d(around.low.x, around.low.y, around.low.z) * kOctomapTileVoxels;
  const Fixed step = fixed(axes.col(0));
  for (int z = slices.from; z < slices.to; ++z) {
    for (int y = 0; y < kOctomapTileVoxels; ++y) {
      Fixed p = fixed(first - origin + axes.col(1) * y + axes.col(2) * z);
      std::int8_t* out = sum->data() + voxel_index(0, y, z);
      for (int x = 0; x < kOctomapTileVoxels; ++x, p.x += step.x, p.y += step.y, p.z += step.z) {
        const auto i = static_cast<unsigned>(p.x) >> kShift;
        const auto j = static_cast<unsigned>(p.y) >> kShift;
        const auto k = static_cast<unsigned>(p.z) >> kShift;
        const VoxelCells* cube = around.cubes[((k >> 5) * kSpan + (j >> 5)) * kSpan + (i >> 5)];
        if (cube == nullptr) continue;
        out[x] = add_clamped(out[x], (*cube)[((k & 31) << 10) | ((j & 31) << 5) | (i & 31)],
                             bounds.low, bounds.high);
      }
    }
  }
  return true;
}

void insert_touched(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m,
                    const SE3& T_map_submap, double edge_map_m, std::set<CubeIndex>* out) {
  Eigen::Array3d low = Eigen::Array3d::Constant(1e9);
  Eigen::Array3d high = -low;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d p = T_map_submap * Eigen::Vector3d((i & 1) != 0 ? high_m.x() : low_m.x(),
                                                             (i & 2) != 0 ? high_m.y() : low_m.y(),
                                                             (i & 4) != 0 ? high_m.z() : low_m.z());
    low = low.min(p.array());
    high = high.max(p.array());
  }
  const Eigen::Array3i a = (low / edge_map_m).floor().cast<int>();
  const Eigen::Array3i b = (high / edge_map_m).floor().cast<int>();
  for (int x = a.x(); x <= b.x(); ++x)
    for (int y = a.y(); y <= b.y(); ++y)
      for (int z = a.z(); z <= b.z(); ++z) out->insert({x, y, z});
}

VoxelCubes unpack_touching(const PackedCubes& packed, const SE3& T_map_submap, double resolution_m,
                           const std::set<CubeIndex>& wanted) {
  const double edge_m = kOctomapTileVoxels * resolution_m;
  const Eigen::Vector3d slack_m = Eigen::Vector3d::Constant(0.1 * resolution_m);  // of rounding
  VoxelCubes cubes;
  for (const auto& [index, bytes] : packed) {
    const Eigen::Vector3d low_m = Eigen::Vector3d(index.x, index.y, index.z) * edge_m;
    std::set<CubeIndex> touched;
    insert_touched(low_m - slack_m, low_m + Eigen::Vector3d::Constant(edge_m) + slack_m,
                   T_map_submap, edge_m, &touched);
    if (std::any_of(touched.begin(), touched.end(),
                    [&](const CubeIndex& cube) { return wanted.count(cube) != 0; }))
      unpack_cells(bytes, &cube_at(&cubes, index));
  }
  return cubes;
}

}  // namespace fusion_slam
