// How well a placed scan agrees with a grid, in numbers a person can read. Pure functions.
#pragma once

#include <cstddef>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

struct Overlap {
  int n_points = 0;
  int n_known = 0;    // points that fall where the grid knows something
  int n_matched = 0;  // points on, or one cell beside, an occupied cell (more probable than not)

  // Of the points in known space, how many agree; 0 when none is there.
  double agreement() const { return n_known > 0 ? static_cast<double>(n_matched) / n_known : 0.0; }
  double coverage() const { return n_points > 0 ? static_cast<double>(n_known) / n_points : 0.0; }
};

Overlap measure_overlap(const Raster& raster, const Points& points_base, const SE2& T_grid_base);

// The points that fall within `reach` cells of a known cell. Points beyond the map's edge must not
// take part in a match: it would be pulled back to where they are covered.
Points points_in_known_space(const Raster& raster, const Points& points_base,
                             const SE2& T_grid_base, int reach);

// The same as places in points_base, ascending.
std::vector<std::size_t> indices_in_known_space(const Raster& raster, const Points& points_base,
                                                const SE2& T_grid_base, int reach);

}  // namespace fusion_slam
