#include "libs/maps/ros_map.hpp"

#include <cmath>
#include <cstdio>

namespace fusion_slam {
namespace {

// Shortest of up to 9 digits, never "-0".
std::string number(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%.9g", std::abs(value) < 1e-12 ? 0.0 : value);
  return text;
}

unsigned char grey(CellState state) {
  if (state == CellState::kUnoccupied) return kPgmFree;
  return state == CellState::kOccupied ? kPgmOccupied : kPgmUnknown;
}

}  // namespace

std::string pgm_bytes(const MapRaster& raster) {
  std::string bytes = "P5\n# Fusion-SLAM " + number(raster.resolution_m) + " m/pixel\n" +
                      std::to_string(raster.width) + " " + std::to_string(raster.height) +
                      "\n255\n";
  bytes.reserve(bytes.size() + raster.probability.size());
  for (int row = raster.height - 1; row >= 0; --row)
    for (int column = 0; column < raster.width; ++column)
      bytes.push_back(
          static_cast<char>(grey(state_of_cell(raster.probability[raster.index(column, row)]))));
  return bytes;
}

std::string map_yaml(const MapRaster& raster, const std::string& image_name) {
  return "image: " + image_name + "\nmode: trinary\nresolution: " + number(raster.resolution_m) +
         "\norigin: [" + number(raster.origin_x_m) + ", " + number(raster.origin_y_m) +
         ", 0]\nnegate: 0\noccupied_thresh: " + number(kOccupiedAbove) +
         "\nfree_thresh: " + number(kFreeBelow) + "\n";
}

}  // namespace fusion_slam
