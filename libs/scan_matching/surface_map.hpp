// Walls finer than cells: for each small square the mean of the points that fell there and of the
// normals they came with, one for each side a wall is seen from. What a grid of occupancy rounds to
// its cells is kept to a fraction of the ranges' noise, in memory proportional to the area.
// After the normal distributions of Biber & Strasser 2003, reduced to mean and normal, which is
// what point-to-line matching needs (Censi 2008, "An ICP variant using a point-to-line metric").
#pragma once

#include <cstdint>
#include <vector>

#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

struct Surface {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();   // mean of the points, m
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  // unit, towards where it was seen from
  int weight = 0;                                    // points in it
};

// Not thread-safe for adding; finding is safe from any thread meanwhile nobody adds.
class SurfaceMap {
 public:
  // Squares of `cell_m`: twice a map's cell is usual.
  explicit SurfaceMap(double cell_m) : first_(cell_m, -1) {}

  // Points and normals in the map's frame, equally many; points whose normal is zero are skipped.
  void add(const Points& points, const Points& normals);

  // The nearest surface in the 3 x 3 squares around `point` that faces as `normal` does (within 45
  // degrees); nullptr: none.
  const Surface* find(const Eigen::Vector2d& point, const Eigen::Vector2d& normal) const;

  std::size_t size() const { return slots_.size(); }

 private:
  struct Slot {
    Eigen::Vector2d normal_sum = Eigen::Vector2d::Zero();
    Surface surface;
    int next = -1;  // of the same square: the other side of a thin wall, or a corner's other wall
  };
  DenseGrid<std::int32_t> first_;  // slot by square; -1: none
  std::vector<Slot> slots_;
};

}  // namespace fusion_slam
