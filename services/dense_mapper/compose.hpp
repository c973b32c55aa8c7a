// The global map out of placed submaps: each voxel of a box of the global lattice looks its centre
// up in every submap (inverse lookup: no holes), and the clamped log-odds are added (equation 4)
// and clamped again.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "services/dense_mapper/dense_submap.hpp"

namespace fusion_slam {

using DenseSubmaps = std::map<std::int64_t, DenseSubmap>;  // by id

// A box of voxels of the map.
struct LatticeBox {
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();  // low corner, map frame
  Eigen::Vector3i size = Eigen::Vector3i::Zero();   // voxels
  double resolution_m = 0.05;
};

// Log-odds in steps of each voxel, x fastest, then y; kUnknownVoxel where no submap knows.
std::vector<std::int8_t> compose_voxels(const DenseSubmaps& submaps, const LatticeBox& box,
                                        const DenseMapperConfig& config);

// Points of all submaps in the tiles `keys` (map frame), one a voxel of the cloud.
std::map<TileKey, std::vector<ColouredPoint>> compose_cloud(const DenseSubmaps& submaps,
                                                            const std::set<TileKey>& keys,
                                                            double cloud_resolution_m);

// Range of tiles of the map of edge_m (in each axis) that a block of a submap touches.
struct TileRange {
  Eigen::Vector3i low;
  Eigen::Vector3i high;  // included
};
TileRange tiles_of_block(const BlockIndex& block, double resolution_m, const SE3& T_map_submap,
                         double edge_m);

}  // namespace fusion_slam
