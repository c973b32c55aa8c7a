// cloud.ply: coloured points for MeshLab, CloudCompare, Open3D, PCL.
#pragma once

#include <string>
#include <vector>

#include "libs/cloud/cloud_tile.hpp"

namespace fusion_slam {

// Binary little-endian PLY: float x y z (metres, map frame), uchar red green blue.
std::string ply_bytes(const std::vector<ColouredPoint>& points);

}  // namespace fusion_slam
