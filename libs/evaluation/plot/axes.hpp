// A rectangle of the sheet with a scale on two sides.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "libs/evaluation/plot/canvas.hpp"

namespace fusion_slam {

struct Range {
  double low = 0.0;
  double high = 1.0;

  double length() const { return high - low; }
};

// Multiples of 1, 2 or 5 times a power of ten inside the range, at most max_count of them.
std::vector<double> ticks(const Range& range, int max_count);
// All of them with as many decimals as the step between them needs.
std::vector<std::string> tick_labels(const std::vector<double>& values);
// The range made larger so that both ends are ticks.
Range rounded_out(const Range& range, int max_count);

class Axes {
 public:
  Axes(cv::Rect2d area_px, Range x, Range y) : area_(area_px), x_(x), y_(y) {}
  // The same scale on both, with the two ranges grown about their middles until they fill the area.
  static Axes with_equal_scale(cv::Rect2d area_px, Range x, Range y);

  cv::Point2d at(double x, double y) const;
  const cv::Rect2d& area() const { return area_; }
  const Range& x() const { return x_; }
  const Range& y() const { return y_; }

  void draw_grid(Canvas& canvas) const;  // below the data
  void draw_frame(Canvas& canvas, const std::string& x_label, const std::string& y_label) const;

 private:
  std::vector<double> x_ticks() const;
  std::vector<double> y_ticks() const;

  cv::Rect2d area_;
  Range x_;
  Range y_;
};

}  // namespace fusion_slam
