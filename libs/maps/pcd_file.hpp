// cloud.pcd: coloured points for PCL, Open3D, CloudCompare and RViz.
#pragma once

#include <string>
#include <vector>

#include "libs/cloud/cloud_tile.hpp"

namespace fusion_slam {

// PCD 0.7, binary: float x y z (metres, map frame), and rgb as PCL packs it: 0x00RRGGBB in the
// four bytes of a float.
std::string pcd_bytes(const std::vector<ColouredPoint>& points);

}  // namespace fusion_slam
