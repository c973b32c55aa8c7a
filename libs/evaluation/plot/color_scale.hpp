// Error to colour, and the bar that explains it.
#pragma once

#include <string>

#include <opencv2/core.hpp>

#include "libs/evaluation/plot/axes.hpp"
#include "libs/evaluation/plot/canvas.hpp"

namespace fusion_slam {

// Viridis (perceptually even, readable when colour-blind) without its palest end, which white paper
// swallows; dark is a great error.
class ColorScale {
 public:
  explicit ColorScale(Range range);
  Color operator()(double error) const;
  const Range& range() const { return range_; }

 private:
  Range range_;
  cv::Mat table_;
};

void draw_color_bar(Canvas& canvas, const cv::Rect2d& area_px, const ColorScale& scale,
                    const std::string& label);

}  // namespace fusion_slam
