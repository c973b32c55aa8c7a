// The upper half of an error plot: where the errors are.
#pragma once

#include <opencv2/core.hpp>

#include "libs/evaluation/plot/canvas.hpp"
#include "libs/evaluation/plot/color_scale.hpp"
#include "libs/evaluation/plot/error_plot.hpp"

namespace fusion_slam {

// Reference, whole estimate and, coloured, the compared part of it, in `area_px`, with a legend
// above.
void draw_map_panel(Canvas& canvas, const cv::Rect2d& area_px, const ErrorPlotData& data,
                    const ColorScale& scale);

}  // namespace fusion_slam
