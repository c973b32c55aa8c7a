// Three pictures side by side: the true map, the estimated one, and where they differ.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "libs/evaluation/map_score.hpp"

namespace fusion_slam {

struct MapPlotData {
  const MapRaster& reference;
  const std::vector<std::uint8_t>& classes;  // or empty
  const ResampledMap& estimate;
  const MapScore& score;
  int tolerance_cells = 1;
  std::string title;
  std::string subtitle;
};

// 1500 pixels wide, BGR; as high as the map needs, at most 1500. Byte-identical for equal input.
cv::Mat draw_map_plot(const MapPlotData& data);

}  // namespace fusion_slam
