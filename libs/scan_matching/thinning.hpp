// Fewer points of a scan, evenly over what it saw.
#pragma once

#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// One point per cell of the smallest grid that leaves at most `most`.
Points thinned(const Points& points, int most);

}  // namespace fusion_slam
