#include "services/dense_mapper/dense_submap.hpp"

#include <algorithm>
#include <cmath>

#include "libs/octree/octomap_tile.hpp"
#include "libs/octree/ray_cast.hpp"

namespace fusion_slam {
namespace {

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
  VoxelWriter writer(marks);
  for (std::size_t i = 0; i < points_submap.size(); ++i) {
    const Eigen::Vector3d end_m = points_submap[i].p_m.cast<double>();
    const double z_m = points_camera[i].p_m.z();
    const Eigen::Vector3d voxel = (end_m / resolution_m).array().floor();
    std::int16_t& mark = writer.at(static_cast<int>(voxel.x()), static_cast<int>(voxel.y()),
                                   static_cast<int>(voxel.z()));
    const auto steps = static_cast<std::int16_t>(hit_steps(z_m, camera, resolution_m, config));
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

}  // namespace

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
                                     const DenseMapperConfig& config, DenseSubmap* submap) {
  std::vector<ColouredPoint> points = cloud.points;
  for (ColouredPoint& point : points)
    point.p_m = (T_submap_camera * point.p_m.cast<double>()).cast<float>();
  VoxelBlocks marks;
  const std::vector<Ray> rays =
      mark_hits(points, cloud.points, camera, resolution_m, config, &marks);
  mark_free(rays, T_submap_camera.translation(), camera, resolution_m, config, &marks);

  std::set<BlockIndex> changed;
  for (const auto& [index, block] : marks.blocks()) {
    changed.insert(index);
    VoxelBlock& sum = submap->voxels.block(index);
    for (std::size_t i = 0; i < block.size(); ++i)
      if (block[i] != kUnknownLogOdds) sum[i] = add_steps(sum[i], block[i]);
  }
  submap->cloud.add(points);
  const Eigen::Matrix3f R = T_submap_camera.linear().cast<float>();
  const Eigen::Vector3f t = T_submap_camera.translation().cast<float>();
  for (const SurfacePoint& surface : cloud.surfaces)
    submap->surfaces.push_back({R * surface.p_m + t, R * surface.normal});
  submap->image_up_sum += T_submap_camera.linear() * Eigen::Vector3d(0, -1, 0);
  submap->camera_positions_m.push_back(T_submap_camera.translation());
  return changed;
}

}  // namespace fusion_slam
