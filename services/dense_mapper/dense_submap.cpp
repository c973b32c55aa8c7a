#include "services/dense_mapper/dense_submap.hpp"

#include <algorithm>
#include <cmath>

#include "libs/octree/octomap_tile.hpp"
#include "libs/octree/ray_cast.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kMostSurfaces = 300;  // of a closed submap: up and floor need no more

double logit(double p) { return std::log(p / (1.0 - p)); }

struct Ray {
  Eigen::Vector3d end_m;  // submap frame
  double z_m = 0.0;       // depth in the camera
};

// Marks the end voxels; returns one ray for each of them (the first that ended there).
std::vector<Ray> mark_hits(const std::vector<ColouredPoint>& points_submap,
                           const std::vector<ColouredPoint>& points_camera,
                           const CameraModel& camera, double resolution_m,
                           const DenseMapperConfig& config, VoxelBlocks* marks) {
  std::vector<Ray> rays;
  std::vector<std::int16_t> steps_of_mm;  // depth comes in mm
  VoxelWriter writer(marks);
  for (std::size_t i = 0; i < points_submap.size(); ++i) {
    const Eigen::Vector3d end_m = points_submap[i].p_m.cast<double>();
    const double z_m = points_camera[i].p_m.z();
    const Eigen::Vector3d voxel = (end_m / resolution_m).array().floor();
    std::int16_t& mark = writer.at(static_cast<int>(voxel.x()), static_cast<int>(voxel.y()),
                                   static_cast<int>(voxel.z()));
    const auto mm = static_cast<std::size_t>(std::lround(z_m * 1000.0));
    if (mm >= steps_of_mm.size()) steps_of_mm.resize(mm + 1000, 0);
    if (steps_of_mm[mm] == 0)
      steps_of_mm[mm] = static_cast<std::int16_t>(
          hit_steps(static_cast<double>(mm) * 1e-3, camera, resolution_m, config));
    const std::int16_t steps = steps_of_mm[mm];
    if (mark == kUnknownLogOdds) rays.push_back({end_m, z_m});
    mark = std::max(mark, steps);
  }
  return rays;
}

void mark_free(const std::vector<Ray>& rays, const Eigen::Vector3d& origin_m,
               const CameraModel& camera, double resolution_m, const DenseMapperConfig& config,
               VoxelBlocks* marks) {
  const auto miss = static_cast<std::int16_t>(miss_steps(config));
  VoxelWriter writer(marks);
  for (const Ray& ray : rays) {
    const Eigen::Vector3d along = ray.end_m - origin_m;
    const double margin_m =
        std::max(resolution_m / 2, config.free_margin_sigmas * camera.depth_sigma(ray.z_m));
    const double fraction = 1.0 - margin_m / ray.z_m;
    if (fraction <= 0.0) continue;
    const Eigen::Vector3d stop_m = origin_m + fraction * along;
    cast_ray(origin_m / resolution_m, stop_m / resolution_m, [&](int x, int y, int z) {
      std::int16_t& mark = writer.at(x, y, z);
      if (mark == kUnknownLogOdds) mark = miss;
    });
  }
}

// Evenly picked.
void thin(std::vector<SurfacePoint>* surfaces) {
  if (surfaces->size() <= kMostSurfaces) return;
  std::vector<SurfacePoint> kept(kMostSurfaces);
  for (std::size_t i = 0; i < kMostSurfaces; ++i)
    kept[i] = (*surfaces)[i * surfaces->size() / kMostSurfaces];
  surfaces->swap(kept);
}

void copy_cube(const CubeIndex& index, const VoxelCells& cells, VoxelBlocks* voxels) {
  const int x0 = index.x * kOctomapTileVoxels;
  const int y0 = index.y * kOctomapTileVoxels;
  const int z0 = index.z * kOctomapTileVoxels;
  VoxelWriter writer(voxels);
  std::size_t i = 0;
  for (int z = 0; z < kOctomapTileVoxels; ++z)
    for (int y = 0; y < kOctomapTileVoxels; ++y)
      for (int x = 0; x < kOctomapTileVoxels; ++x, ++i)
        // NOLINTNEXTLINE(bugprone-signed-char-misuse): steps of log-odds, no characters
        if (cells[i] != kUnknownVoxel) writer.at(x0 + x, y0 + y, z0 + z) = cells[i];
}

}  // namespace

StepBounds step_bounds(const DenseMapperConfig& config) {
  return {log_odds_to_step(config.log_odds_min), log_odds_to_step(config.log_odds_max)};
}

int hit_steps(double z_m, const CameraModel& camera, double resolution_m,
              const DenseMapperConfig& config) {
  const double sigma_m = std::max(camera.depth_sigma(z_m), 1e-6);
  const double inside = std::erf(resolution_m / (2.0 * std::sqrt(2.0) * sigma_m));
  const double p = 0.5 + (config.probability_hit - 0.5) * inside;
  return std::max(1, static_cast<int>(std::lround(logit(p) / kLogOddsStep)));
}

int miss_steps(const DenseMapperConfig& config) {
  return static_cast<int>(std::lround(logit(config.probability_miss) / kLogOddsStep));
}

std::set<BlockIndex> integrate_cloud(const DepthCloud& cloud, const SE3& T_submap_camera,
                                     const CameraModel& camera, double resolution_m,
                                     const DenseMapperConfig& config, bool keep_surfaces,
                                     DenseSubmap* submap) {
  std::vector<ColouredPoint> points = cloud.points;
  for (ColouredPoint& point : points)
    point.p_m = (T_submap_camera * point.p_m.cast<double>()).cast<float>();
  VoxelBlocks marks;
  const std::vector<Ray> rays =
      mark_hits(points, cloud.points, camera, resolution_m, config, &marks);
  mark_free(rays, T_submap_camera.translation(), camera, resolution_m, config, &marks);

  const StepBounds bounds = step_bounds(config);
  std::set<BlockIndex> changed;
  for (const auto& [index, block] : marks.blocks()) {
    changed.insert(index);
    VoxelBlock& sum = submap->voxels.block(index);
    for (std::size_t i = 0; i < block.size(); ++i)
      if (block[i] != kUnknownLogOdds) sum[i] = add_steps(sum[i], block[i]);
    copy_block(index, sum, bounds.low, bounds.high, &submap->cubes);
  }
  std::vector<ColouredPoint> sparse;
  for (const std::uint32_t i : cloud.sparse) sparse.push_back(points[i]);
  submap->cloud.add(sparse);
  ++submap->n_keyframes;
  if (!keep_surfaces) return changed;
  const Eigen::Matrix3f R = T_submap_camera.linear().cast<float>();
  const Eigen::Vector3f t = T_submap_camera.translation().cast<float>();
  for (const SurfacePoint& surface : cloud.surfaces)
    submap->surfaces.push_back({R * surface.p_m + t, R * surface.normal});
  submap->image_up_sum += T_submap_camera.linear() * Eigen::Vector3d(0, -1, 0);
  submap->camera_positions_m.push_back(T_submap_camera.translation());
  return changed;
}

std::size_t size_bytes(const DenseSubmap& submap) {
  std::size_t sum = size_bytes(submap.packed);
  for (const auto& [key, bytes] : submap.packed_cloud) sum += bytes.size();
  return sum;
}

void close_submap(double resolution_m, DenseSubmap* submap) {
  submap->closed = true;
  submap->packed = pack_cubes(submap->cubes);
  submap->packed_cloud = pack_cloud(submap->cloud.points(), submap->cloud.resolution_m());
  submap->voxels = VoxelBlocks{};
  submap->cubes.clear();
  submap->cloud = VoxelCloud(submap->cloud.resolution_m());
  const std::set<CubeIndex> touched = touched_cubes(*submap, resolution_m);
  submap->touches.assign(touched.begin(), touched.end());
  thin(&submap->surfaces);
}

void open_submap(DenseSubmap* submap) {
  submap->closed = false;
  submap->cubes = unpack_cubes(submap->packed);
  for (const auto& [index, cells] : submap->cubes) copy_cube(index, *cells, &submap->voxels);
  submap->cloud.add(unpack_cloud(submap->packed_cloud, submap->cloud.resolution_m()));
  submap->packed.clear();
  submap->packed_cloud.clear();
}

std::set<CubeIndex> touched_cubes(const DenseSubmap& submap, double resolution_m) {
  std::set<CubeIndex> touched;
  const double edge_m = kOctomapTileVoxels * resolution_m;
  const auto insert = [&](const CubeIndex& index) {
    const Eigen::Vector3d low_m = Eigen::Vector3d(index.x, index.y, index.z) * edge_m;
    insert_touched(low_m, low_m + Eigen::Vector3d::Constant(edge_m), submap.T_map_submap, edge_m,
                   &touched);
  };
  for (const auto& [index, bytes] : submap.packed) insert(index);
  for (const auto& [index, cells] : submap.cubes) insert(index);
  return touched;
}

std::vector<ColouredPoint> unpack_cloud(const PackedCloud& packed, double cloud_resolution_m) {
  std::vector<ColouredPoint> points;
  Tile tile;
  tile.resolution_m = cloud_resolution_m;
  tile.size_cells = kCloudTileVoxels;
  tile.encoding = TileEncoding::kCloud;
  for (const auto& [key, bytes] : packed) {
    tile.key = key;
    tile.data = bytes;
    if (const auto some = decode_cloud_tile(tile))
      points.insert(points.end(), some->begin(), some->end());
  }
  return points;
}

PackedCloud pack_cloud(const std::vector<ColouredPoint>& points, double cloud_resolution_m) {
  std::map<TileKey, std::vector<ColouredPoint>> by_tile;
  for (const ColouredPoint& point : points)
    by_tile[cloud_tile_of(0, point.p_m.cast<double>(), cloud_resolution_m)].push_back(point);
  PackedCloud packed;
  for (const auto& [key, some] : by_tile) {
    PackedBytes bytes = encode_cloud_tile(key, some, cloud_resolution_m, 0, 0).data;
    bytes.shrink_to_fit();
    packed.emplace(key, std::move(bytes));
  }
  return packed;
}

}  // namespace fusion_slam
