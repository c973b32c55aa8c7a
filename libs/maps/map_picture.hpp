// map.png: the map as people look at it, with the way the robot took, a scale bar and a legend.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "libs/maps/map_raster.hpp"

namespace fusion_slam {

// A PNG of at least 900 pixels across. Walls are coloured by the sensor that saw them when the
// raster holds both; the palette (Okabe & Ito 2008) can be told apart by the colour-blind. way_m:
// positions in the map, in order of time; may be empty. A map of more than 8192 cells across, with
// the way, is drawn with several cells (the occupied ones first) as one. Byte-identical for equal
// input.
std::string map_png_bytes(const MapRaster& raster, const std::vector<Eigen::Vector2d>& way_m);

}  // namespace fusion_slam
