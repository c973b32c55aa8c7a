// A small OctoMap and cloud, rigid in the frame of its anchor keyframe's base. The graph moves the
// anchor; what is inside is never integrated again. Open while keyframes come; closed it is kept
// packed.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "libs/cloud/voxel_cloud.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/octree/voxel_blocks.hpp"
#include "libs/octree/voxel_pack.hpp"
#include "services/dense_mapper/compose.hpp"
#include "services/dense_mapper/config.hpp"
#include "services/dense_mapper/depth_cloud.hpp"

namespace fusion_slam {

constexpr double kCloudVoxelsPerCell = 2.0;  // the cloud is twice as fine as the OctoMap

using PackedCloud = std::map<TileKey, PackedBytes>;  // content of CLOUD tiles, by tile

struct DenseSubmap {
  explicit DenseSubmap(double cloud_resolution_m) : cloud(cloud_resolution_m) {}

  // --- while open
  VoxelBlocks voxels;  // sums
  VoxelCubes cubes;    // the same within the bounds, as composed
  VoxelCloud cloud;
  // --- when closed
  bool closed = false;
  PackedCubes packed;
  PackedCloud packed_cloud;
  std::vector<CubeIndex> touches;  // cubes of the map, sorted, as placed
  int newer = 0;                   // submaps closed since that overlap it: see supersede.hpp
  int visits = 0;                  // of drop_superseded()

  int n_keyframes = 0;
  SE3 T_map_submap = SE3::Identity();  // as composed
  SE3 T_true_base = SE3::Identity();   // correction of the mounting that is built in
  // --- for levelling a hand-held camera's map
  std::vector<SurfacePoint> surfaces;                      // submap frame
  Eigen::Vector3d image_up_sum = Eigen::Vector3d::Zero();  // up in the images, submap frame
  std::vector<Eigen::Vector3d> camera_positions_m;         // submap frame
};

using DenseSubmaps = std::map<std::int64_t, DenseSubmap>;  // by id

StepBounds step_bounds(const DenseMapperConfig& config);

// Log-odds of the end voxel of a ray of depth z_m (equation 3), in steps of kLogOddsStep: the less
// certain it is that the surface lies in this voxel at all, the less it says. With sigma(z) of the
// camera: p = 0.5 + (p_hit - 0.5) erf(r / (2 sqrt 2 sigma)).
int hit_steps(double z_m, const CameraModel& camera, double resolution_m,
              const DenseMapperConfig& config);
int miss_steps(const DenseMapperConfig& config);

// Adds a keyframe's cloud (camera frame) to an open submap: equation 4. Each voxel counts once a
// keyframe: hit when a point ends in it, else free when a ray passes. keep_surfaces: for levelling.
// Returns the blocks that changed.
std::set<BlockIndex> integrate_cloud(const DepthCloud& cloud, const SE3& T_submap_camera,
                                     const CameraModel& camera, double resolution_m,
                                     const DenseMapperConfig& config, bool keep_surfaces,
                                     DenseSubmap* submap);

std::size_t size_bytes(const DenseSubmap& submap);  // of what a closed one keeps packed

// Packs an open submap; opens a packed one again, to integrate a keyframe that came late (sums
// beyond the bounds are forgotten).
void close_submap(double resolution_m, DenseSubmap* submap);
void open_submap(DenseSubmap* submap);

// Cubes of the map that it touches as placed.
std::set<CubeIndex> touched_cubes(const DenseSubmap& submap, double resolution_m);

// Points of a closed submap, in its frame.
std::vector<ColouredPoint> unpack_cloud(const PackedCloud& packed, double cloud_resolution_m);
PackedCloud pack_cloud(const std::vector<ColouredPoint>& points, double cloud_resolution_m);

}  // namespace fusion_slam
