// The lower half of an error plot: when the errors are, and when there was no estimate.
#pragma once

#include <string>

#include <opencv2/core.hpp>

#include "libs/evaluation/plot/axes.hpp"
#include "libs/evaluation/plot/canvas.hpp"
#include "libs/evaluation/plot/error_plot.hpp"

namespace fusion_slam {

void draw_time_panel(Canvas& canvas, const cv::Rect2d& area_px, const ErrorPlotData& data,
                     const Range& error_range, const std::string& error_label);

}  // namespace fusion_slam
