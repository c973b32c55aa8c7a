// Thins points so that near surfaces, which get most beams, don't outvote far ones. Pure functions.
#pragma once

#include <cstddef>
#include <vector>

#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// Indices of the first point of each square of `edge_m`, ascending.
std::vector<std::size_t> voxel_indices(const Points& points, double edge_m);

// With the largest edge up to max_edge_m that leaves at least min_points (Hess et al. 2016, section
// IV.D); all points when there are no more than that.
std::vector<std::size_t> adaptive_voxel_indices(const Points& points, double max_edge_m,
                                                int min_points);

// Those elements of `all`, in that order.
template <class T>
std::vector<T> pick(const std::vector<T>& all, const std::vector<std::size_t>& indices) {
  std::vector<T> some;
  some.reserve(indices.size());
  for (const std::size_t i : indices) some.push_back(all[i]);
  return some;
}

}  // namespace fusion_slam
