// A coloured cloud with one point a voxel: the mean of all points that fell into it. Sums are
// integers, so the order in which points are added does not matter.
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "libs/cloud/cloud_tile.hpp"

namespace fusion_slam {

struct CloudVoxel {
  std::int32_t x = 0;  // voxel index
  std::int32_t y = 0;
  std::int32_t z = 0;
  std::int32_t count = 0;
  std::int32_t sum_x = 0;  // offsets from the voxel's low corner, 1/1024 of a voxel
  std::int32_t sum_y = 0;
  std::int32_t sum_z = 0;
  std::int32_t sum_r = 0;
  std::int32_t sum_g = 0;
  std::int32_t sum_b = 0;

  bool operator<(const CloudVoxel& other) const {
    return std::tie(z, y, x) < std::tie(other.z, other.y, other.x);
  }
};

class VoxelCloud {
 public:
  explicit VoxelCloud(double resolution_m) : resolution_m_(resolution_m) {}

  void add(const std::vector<ColouredPoint>& points);
  double resolution_m() const { return resolution_m_; }
  std::size_t size() const { return voxels_.size(); }
  std::vector<ColouredPoint> points() const;  // ordered by voxel z, y, x

 private:
  double resolution_m_;
  std::vector<CloudVoxel> voxels_;  // sorted, each voxel once
};

}  // namespace fusion_slam
