// Charts as SVG: sharp at every size and on paper, coloured by the page's style sheet
// (libs/report/style.hpp) so that they follow dark and light. Pure functions; equal input gives
// equal bytes.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace fusion_slam {

struct Series {
  std::string name;
  std::vector<Eigen::Vector2d> points;  // ordered by x
};

struct LineChart {
  std::string title;
  std::string x_label;  // with its unit
  std::string y_label;
  std::vector<Series> series;  // at most 8 have a colour of their own
  bool breaks = true;          // where nothing was for ten times the usual step of x
};

// Always shows y = 0. More than 1,500 points of a series are thinned so that the highest and the
// lowest of each stretch stay. A sentence in place of a chart when no point is finite.
std::string line_chart_svg(const LineChart& chart);

struct Histogram {
  std::string title;
  std::string x_label;
  std::vector<double> values;
};

// 40 bins from 0 to the 99.5th percentile; what is beyond is counted in the last, which says so.
std::string histogram_svg(const Histogram& histogram);

}  // namespace fusion_slam
