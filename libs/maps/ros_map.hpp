// map.pgm and map.yaml as ROS map_server and nav2 read and write them.
#pragma once

#include <string>

#include "libs/maps/map_raster.hpp"

namespace fusion_slam {

// Grey values of a trinary map. Readers know a cell's state by the thresholds alone: unknown must
// lie between them, which map_saver's customary 205 does not, (255 - 205) / 255 = 0.196 being below
// free_thresh 0.25 (navigation2 pull request 5278).
constexpr unsigned char kPgmFree = 254;
constexpr unsigned char kPgmOccupied = 0;
constexpr unsigned char kPgmUnknown = 128;

// Binary PGM (P5). The picture's first row is the map's largest y.
std::string pgm_bytes(const MapRaster& raster);

// origin is the pose of the picture's lower left pixel's lower left corner, in metres.
std::string map_yaml(const MapRaster& raster, const std::string& image_name);

}  // namespace fusion_slam
