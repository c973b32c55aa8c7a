// A small OctoMap and cloud, rigid in the frame of its anchor keyframe's base. The graph moves the
// anchor; what is inside is never integrated again.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "libs/cloud/voxel_cloud.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/octree/voxel_blocks.hpp"
#include "services/dense_mapper/config.hpp"
#include "services/dense_mapper/depth_cloud.hpp"

namespace fusion_slam {

struct DenseSubmap {
  explicit DenseSubmap(double cloud_resolution_m) : cloud(cloud_resolution_m) {}

  VoxelBlocks voxels;
  VoxelCloud cloud;
  std::vector<SurfacePoint> surfaces;                      // submap frame
  Eigen::Vector3d image_up_sum = Eigen::Vector3d::Zero();  // up in the images, submap frame
  std::vector<Eigen::Vector3d> camera_positions_m;         // submap frame
  SE3 T_map_submap = SE3::Identity();                      // as composed
};

// Log-odds of the end voxel of a ray of depth z_m (equation 3), in steps of kLogOddsStep: the less
// certain it is that the surface lies in this voxel at all, the less it says. With sigma(z) of the
// camera: p = 0.5 + (p_hit - 0.5) erf(r / (2 sqrt 2 sigma)).
int hit_steps(double z_m, const CameraModel& camera, double resolution_m,
              const DenseMapperConfig& config);
int miss_steps(const DenseMapperConfig& config);

// Adds a keyframe's cloud (camera frame) to the submap: equation 4. Each voxel counts once a
// keyframe: hit when a point ends in it, else free when a ray passes. Returns the blocks that
// changed.
std::set<BlockIndex> integrate_cloud(const DepthCloud& cloud, const SE3& T_submap_camera,
                                     const CameraModel& camera, double resolution_m,
                                     const DenseMapperConfig& config, DenseSubmap* submap);

}  // namespace fusion_slam
