#include "libs/report/top_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Geometry>

#include "libs/evaluation/plot/color_scale.hpp"
#include "libs/report/html.hpp"

namespace fusion_slam {
namespace {

constexpr double kWidth = 760.0, kMostHeight = 640.0, kLegend = 54.0, kMargin_m = 0.4;
constexpr std::size_t kMostPoints = 3000;
constexpr double kJump_m = 2.0;  // the line breaks there

struct Frame {
  Eigen::AlignedBox2d box_m;
  double scale = 1.0;  // pixels a metre
  double left = 0.0;   // pixels

  double px(double x_m) const { return left + (x_m - box_m.min().x()) * scale; }
  double py(double y_m) const { return kLegend + (box_m.max().y() - y_m) * scale; }
  std::string at(const Eigen::Vector2d& p) const {
    return number(px(p.x()), 1) + " " + number(py(p.y()), 1);
  }
};

Eigen::AlignedBox2d extent(const TopView& view) {
  Eigen::AlignedBox2d box;
  if (view.map && view.map->width_m > 0.0 && view.map->height_m > 0.0) {
    box.extend(Eigen::Vector2d(view.map->x_m, view.map->y_m));
    box.extend(
        Eigen::Vector2d(view.map->x_m + view.map->width_m, view.map->y_m + view.map->height_m));
  }
  for (const Way& way : view.ways)
    for (const Eigen::Vector2d& p : way.points_m)
      if (p.allFinite()) box.extend(p);
  if (!box.isEmpty()) {
    box.min().array() -= kMargin_m;
    box.max().array() += kMargin_m;
  }
  return box;
}

std::string css(const Color& color) {
  char text[16];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", static_cast<unsigned>(color[2]),
                static_cast<unsigned>(color[1]), static_cast<unsigned>(color[0]));
  return text;
}

std::string draw_way(const Way& way, const Frame& frame, const ColorScale& colors) {
  const std::size_t n = way.points_m.size();
  const std::size_t step = n / kMostPoints + 1;
  const bool colored = way.errors_m.size() == n;
  std::string svg = "<g class=\"" + way.style + "\">\n", path, color;
  std::size_t last = n;
  const auto finish = [&] {
    if (path.find('L') != std::string::npos)
      svg += "<path d=\"" + path + "\"" + (colored ? " stroke=\"" + color + "\"" : "") + "/>\n";
    path.clear();
  };
  for (std::size_t i = 0; i < n; i += step) {
    const Eigen::Vector2d& p = way.points_m[i];
    if (!p.allFinite()) continue;
    const bool jump = last == n || (p - way.points_m[last]).norm() > kJump_m;
    const std::string now = colored ? css(colors(way.errors_m[i])) : std::string();
    if (jump || now != color) {
      finish();
      path = "M" + frame.at(jump ? p : way.points_m[last]);
      color = now;
    }
    path += "L" + frame.at(p);
    last = i;
  }
  finish();
  return svg + "</g>\n";
}

std::string scale_bar(const Frame& frame) {
  double bar_m = 1.0;
  for (const double candidate : {0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 500.0})
    if (candidate * frame.scale <= 160.0) bar_m = candidate;
  return "<path class=\"ink\" d=\"M10 44v-6v3h" + number(bar_m * frame.scale, 1) +
         "v-3v6\"/><text x=\"" + number(18.0 + bar_m * frame.scale, 1) + "\" y=\"45\">" +
         number(bar_m, bar_m < 1.0 ? 1 : 0) + " m</text>\n";
}

std::string color_bar(const ColorScale& colors) {
  std::string svg =
      "<text x=\"" + number(kWidth - 196, 0) + "\" y=\"45\" text-anchor=\"end\">error 0</text>";
  const double worst = colors.range().high;
  for (int i = 0; i < 24; ++i)
    svg += "<rect x=\"" + number(kWidth - 190 + 5 * i, 0) +
           "\" y=\"34\" width=\"5.5\" height=\"12\" fill=\"" + css(colors(worst * i / 23.0)) +
           "\"/>";
  return svg + "<text x=\"" + number(kWidth - 64, 0) + "\" y=\"45\">" + number(worst, 3) +
         " m</text>\n";
}

}  // namespace

std::string top_view_svg(const TopView& view) {
  Frame frame{extent(view), 1.0, 0.0};
  if (frame.box_m.isEmpty() || !frame.box_m.sizes().allFinite())
    return "<p class=\"quiet\">" + escape_html(view.title) + ": nothing to show.</p>\n";
  const Eigen::Vector2d size_m = frame.box_m.sizes();
  frame.scale = std::min((kWidth - 20.0) / size_m.x(), kMostHeight / size_m.y());
  frame.left = 0.5 * (kWidth - size_m.x() * frame.scale);
  double worst = view.worst_error_m;
  bool any_errors = false;
  for (const Way& way : view.ways)
    for (const double error : way.errors_m) {
      any_errors = true;
      if (view.worst_error_m <= 0.0 && std::isfinite(error)) worst = std::max(worst, error);
    }
  const ColorScale colors(Range{0.0, worst > 0.0 ? worst : 1.0});
  std::string svg = "<svg class=\"top\" role=\"img\" aria-label=\"" + escape_html(view.title) +
                    "\" viewBox=\"0 0 " + number(kWidth, 0) + " " +
                    number(kLegend + size_m.y() * frame.scale + 10.0, 0) + "\">\n" +
                    "<text class=\"title\" x=\"0\" y=\"14\">" + escape_html(view.title) +
                    "</text>\n";
  if (view.map)
    svg += "<rect class=\"unknown\" x=\"" + number(frame.left, 2) + "\" y=\"" + number(kLegend, 2) +
           "\" width=\"" + number(size_m.x() * frame.scale, 2) + "\" height=\"" +
           number(size_m.y() * frame.scale, 2) + "\" rx=\"4\"/>\n";
  if (view.map)
    svg += "<image x=\"" + number(frame.px(view.map->x_m), 2) + "\" y=\"" +
           number(frame.py(view.map->y_m + view.map->height_m), 2) + "\" width=\"" +
           number(view.map->width_m * frame.scale, 2) + "\" height=\"" +
           number(view.map->height_m * frame.scale, 2) +
           "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64," + base64(view.map->png) +
           "\"/>\n";
  for (const Way& way : view.ways) svg += draw_way(way, frame, colors);
  for (const Link& link : view.links)
    svg += "<path class=\"" + link.style + "\" d=\"M" + frame.at(link.from_m) + "L" +
           frame.at(link.to_m) + "\"><title>" + escape_html(link.about) + "</title></path>\n";
  double legend = 250.0;
  for (const Way& way : view.ways) {
    svg += "<g class=\"" + way.style + "\"><path d=\"M" + number(legend, 1) +
           " 41h20\" stroke=\"#3b528b\"/></g><text x=\"" + number(legend + 26, 1) + "\" y=\"45\">" +
           escape_html(way.name) + "</text>\n";
    legend += 44.0 + 6.6 * static_cast<double>(way.name.size());
  }
  return svg + scale_bar(frame) + (any_errors ? color_bar(colors) : std::string()) + "</svg>\n";
}

}  // namespace fusion_slam
