#include "libs/cloud/voxel_cloud.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr double kUnits = 1024.0;
constexpr std::int32_t kMostPoints = 1'000'000;  // sums stay within 32 bits

std::int32_t offset(double voxels) {
  return static_cast<std::int32_t>(std::lround(voxels * kUnits));
}

CloudVoxel voxel_of(const ColouredPoint& point, double resolution_m) {
  const Eigen::Vector3d p = point.p_m.cast<double>() / resolution_m;
  const Eigen::Vector3d corner = p.array().floor();
  CloudVoxel voxel;
  voxel.x = static_cast<std::int32_t>(corner.x());
  voxel.y = static_cast<std::int32_t>(corner.y());
  voxel.z = static_cast<std::int32_t>(corner.z());
  voxel.count = 1;
  voxel.sum_x = offset(p.x() - corner.x());
  voxel.sum_y = offset(p.y() - corner.y());
  voxel.sum_z = offset(p.z() - corner.z());
  voxel.sum_r = point.r;
  voxel.sum_g = point.g;
  voxel.sum_b = point.b;
  return voxel;
}

void merge_into(CloudVoxel* a, const CloudVoxel& b) {
  if (a->count + b.count > kMostPoints) return;  // the mean is known well enough
  a->count += b.count;
  a->sum_x += b.sum_x;
  a->sum_y += b.sum_y;
  a->sum_z += b.sum_z;
  a->sum_r += b.sum_r;
  a->sum_g += b.sum_g;
  a->sum_b += b.sum_b;
}

// Sorted input, equal voxels side by side.
std::vector<CloudVoxel> merged(const std::vector<CloudVoxel>& sorted) {
  std::vector<CloudVoxel> out;
  out.reserve(sorted.size());
  for (const CloudVoxel& voxel : sorted) {
    const bool same = !out.empty() && !(out.back() < voxel);
    if (same)
      merge_into(&out.back(), voxel);
    else
      out.push_back(voxel);
  }
  return out;
}

}  // namespace

void VoxelCloud::add(const std::vector<ColouredPoint>& points) {
  std::vector<CloudVoxel> fresh;
  fresh.reserve(points.size());
  for (const ColouredPoint& point : points)
    if (point.p_m.allFinite()) fresh.push_back(voxel_of(point, resolution_m_));
  std::sort(fresh.begin(), fresh.end());
  fresh = merged(fresh);
  std::vector<CloudVoxel> both(voxels_.size() + fresh.size());
  std::merge(voxels_.begin(), voxels_.end(), fresh.begin(), fresh.end(), both.begin());
  voxels_ = merged(both);
}

std::vector<ColouredPoint> VoxelCloud::points() const {
  std::vector<ColouredPoint> out(voxels_.size());
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    const CloudVoxel& voxel = voxels_[i];
    const Eigen::Vector3d corner(voxel.x, voxel.y, voxel.z);
    const Eigen::Vector3d sum(voxel.sum_x, voxel.sum_y, voxel.sum_z);
    out[i].p_m = ((corner + sum / (kUnits * voxel.count)) * resolution_m_).cast<float>();
    out[i].r = static_cast<std::uint8_t>(voxel.sum_r / voxel.count);
    out[i].g = static_cast<std::uint8_t>(voxel.sum_g / voxel.count);
    out[i].b = static_cast<std::uint8_t>(voxel.sum_b / voxel.count);
  }
  return out;
}

}  // namespace fusion_slam
