// Reads map.yaml + its picture as ROS map_server and nav2 do (mode trinary).
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "libs/maps/map_raster.hpp"

namespace fusion_slam {

// A grey picture in the order of MapRaster: row 0 is the picture's last.
struct GreyRaster {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> values;
};

// PGM, PNG or any other picture OpenCV reads. Throws std::runtime_error: file, reason, what to do.
GreyRaster read_grey(const std::filesystem::path& file);

// Cells become 255 (occupied), 1 (free) or kUnknownCell by the file's own thresholds and `negate`;
// provenance is all 0. Throws std::runtime_error with the file, the key and what to do: a key is
// missing or no number, the picture can't be read, the map is turned (origin's yaw is not 0), the
// mode is not trinary.
MapRaster read_ros_map(const std::filesystem::path& yaml_file);

}  // namespace fusion_slam
