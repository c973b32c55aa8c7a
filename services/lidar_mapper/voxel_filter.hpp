// Thins points so that near surfaces, which get most beams, don't outvote far ones. Pure functions.
#pragma once

#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// The first point of each square of `edge_m`, in the order of the input.
Points voxel_filter(const Points& points, double edge_m);

// With the largest edge up to max_edge_m that leaves at least min_points (Hess et al. 2016, section
// IV.D); all points when there are no more than that.
Points adaptive_voxel_filter(const Points& points, double max_edge_m, int min_points);

}  // namespace fusion_slam
