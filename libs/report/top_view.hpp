// A map from above with ways and links drawn over it, as SVG. Pure functions; equal input gives
// equal bytes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace fusion_slam {

struct MapImage {
  std::string png;              // row 0 of the picture is the largest y
  double x_m = 0.0, y_m = 0.0;  // lower left corner
  double width_m = 0.0, height_m = 0.0;
};

struct Way {
  std::string name;
  std::string style;                      // class of the style sheet: "truth", "way"
  std::vector<Eigen::Vector2d> points_m;  // in order of time
  std::vector<double> errors_m;           // empty, or one a point: coloured by it
};

struct Link {
  Eigen::Vector2d from_m, to_m;
  std::string style;  // "closure", "off"
  std::string about;  // shown when pointed at
};

struct TopView {
  std::string title;
  std::optional<MapImage> map;
  std::vector<Way> ways;
  std::vector<Link> links;
  double worst_error_m = 0.0;  // darkest colour of the ways; 0: the largest error there is
};

// With a scale bar, a legend, and a colour bar where a way has errors. Ways of more than 3,000
// points are thinned. A sentence in place of a picture when there is nothing.
std::string top_view_svg(const TopView& view);

}  // namespace fusion_slam
