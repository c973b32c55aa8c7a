// Placed submaps into the cubes of the map. Each voxel of the map looks its centre up in a submap
// (inverse lookup: no holes). Pure functions.
#pragma once

#include <cstdint>
#include <set>

#include "libs/geometry/pose.hpp"
#include "libs/octree/voxel_pack.hpp"

namespace fusion_slam {

// Bounds of a voxel's log-odds, in steps (equation 4 with OctoMap's clamping).
struct StepBounds {
  int low = -64;
  int high = 112;
};

// Slices [from, to) of a cube's z, 0 <= from <= to <= 32.
struct SliceRange {
  int from = 0;
  int to = kOctomapTileVoxels;
};

// Adds what a submap says about the cube `index` of the map to `sum`, clamped voxel by voxel
// (add_clamped), in the given slices. T_submap_map in metres, both frames with voxels of
// resolution_m. False: the submap has no voxel there.
bool add_submap(const VoxelCubes& submap, const SE3& T_submap_map, const CubeIndex& index,
                double resolution_m, const StepBounds& bounds, const SliceRange& slices,
                VoxelCells* sum);

// Cubes of the map (edge edge_map_m) that a box [low_m, high_m] of a submap touches.
void insert_touched(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m,
                    const SE3& T_map_submap, double edge_map_m, std::set<CubeIndex>* out);

// The packed cubes of a submap that may touch cubes of the map, `wanted`, unpacked: what
// add_submap() looks at when it is asked for these.
VoxelCubes unpack_touching(const PackedCubes& packed, const SE3& T_map_submap, double resolution_m,
                           const std::set<CubeIndex>& wanted);

}  // namespace fusion_slam
