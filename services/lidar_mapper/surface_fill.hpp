// Points between beams that hit the same flat surface. A sweep draws a far wall as dots; a map of
// dots holds the next scan at the dots, and a robot that drives along a corridor seems to stand.
// Pure function.
#pragma once

#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// `hits` in the order of the beams; origin is the sensor's. The result holds the points between
// neighbours that are more than spacing_m apart, about spacing_m from each other, where the
// neighbour before or after continues the same line. radstep_rad: angle between beams; noise_m: of
// a range.
Points fill_surfaces(const Points& hits, const Eigen::Vector2d& origin, double radstep_rad,
                     double spacing_m, double noise_m);

}  // namespace fusion_slam
