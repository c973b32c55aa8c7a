// Which way the surface faces that a beam ended on, from the beams beside it. Pure functions.
#pragma once

#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// Unit normals of the points, towards `origin` (where the beams came from); zero where a point
// belongs to no straight piece: corners, thin things, single points. The points must be in the
// order of the beams and in one frame with `origin`, metres. The line through the neighbours within
// about 0.35 m on either side, by least squares; farther apart, through one neighbour on each side;
// where the view of a wall ends, through two on the side that is seen.
Points surface_normals(const Points& points, const Eigen::Vector2d& origin);

}  // namespace fusion_slam
