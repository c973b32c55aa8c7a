#include "libs/report/chart.hpp"

#include <algorithm>
#include <cmath>

#include "libs/evaluation/plot/axes.hpp"
#include "libs/report/html.hpp"

namespace fusion_slam {
namespace {

constexpr double kWidth = 760.0, kHeight = 260.0;
constexpr double kLeft = 58.0, kRight = 14.0, kTop = 42.0, kBottom = 40.0;
constexpr std::size_t kMostPoints = 1500;
constexpr int kBins = 40;

struct Frame {
  Range x, y;

  double px(double value) const {
    return kLeft + (value - x.low) / x.length() * (kWidth - kLeft - kRight);
  }
  double py(double value) const {
    return kHeight - kBottom - (value - y.low) / y.length() * (kHeight - kTop - kBottom);
  }
};

std::string at(const char* name, double value) {
  return std::string(" ") + name + "=\"" + number(value, 1) + "\"";
}

std::string text_at(double x, double y, const char* anchor, const std::string& text) {
  return "<text" + at("x", x) + at("y", y) + " text-anchor=\"" + anchor + "\">" +
         escape_html(text) + "</text>";
}

std::string begin(const std::string& title, const Frame& frame, const std::string& x_label,
                  const std::string& y_label) {
  std::string svg = "<svg class=\"chart\" role=\"img\" aria-label=\"" + escape_html(title) +
                    "\" viewBox=\"0 0 " + number(kWidth, 0) + " " + number(kHeight, 0) + "\">\n" +
                    "<text class=\"title\" x=\"0\" y=\"14\">" + escape_html(title) + "</text>\n";
  const auto rows = ticks(frame.y, 6), columns = ticks(frame.x, 9);
  const auto row_names = tick_labels(rows), column_names = tick_labels(columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double y = frame.py(rows[i]);
    svg += "<line class=\"grid\"" + at("x1", kLeft) + at("x2", kWidth - kRight) + at("y1", y) +
           at("y2", y) + "/>" + text_at(kLeft - 7, y + 4, "end", row_names[i]) + "\n";
  }
  for (std::size_t i = 0; i < columns.size(); ++i)
    svg += text_at(frame.px(columns[i]), kHeight - kBottom + 17, "middle", column_names[i]) + "\n";
  return svg + text_at(0.5 * (kLeft + kWidth - kRight), kHeight - 5, "middle", x_label) + "\n" +
         "<text transform=\"translate(12 " + number(0.5 * (kTop + kHeight - kBottom), 1) +
         ") rotate(-90)\" text-anchor=\"middle\">" + escape_html(y_label) + "</text>\n";
}

// The first, last, lowest and highest of each stretch.
std::vector<Eigen::Vector2d> thinned(const std::vector<Eigen::Vector2d>& points) {
  if (points.size() <= kMostPoints) return points;
  std::vector<Eigen::Vector2d> few;
  const std::size_t stretch = (points.size() * 4 + kMostPoints - 1) / kMostPoints;
  for (std::size_t i = 0; i < points.size(); i += stretch) {
    const std::size_t end = std::min(points.size(), i + stretch);
    std::size_t low = i, high = i;
    for (std::size_t k = i; k < end; ++k) {
      if (points[k].y() < points[low].y()) low = k;
      if (points[k].y() > points[high].y()) high = k;
    }
    std::size_t kept[] = {i, low, high, end - 1};
    std::sort(std::begin(kept), std::end(kept));
    const std::size_t* const kept_end = std::unique(std::begin(kept), std::end(kept));
    for (const std::size_t* k = kept; k != kept_end; ++k) few.push_back(points[*k]);
  }
  return few;
}

std::string path_of(const std::vector<Eigen::Vector2d>& points, const Frame& frame, double gap) {
  std::string path;
  bool down = false;
  double last_x = 0.0;
  for (const Eigen::Vector2d& p : points) {
    if (!p.allFinite()) {
      down = false;
      continue;
    }
    if (down && gap > 0.0 && p.x() - last_x > gap) down = false;
    path += (down ? "L" : "M") + number(frame.px(p.x()), 1) + " " + number(frame.py(p.y()), 1);
    down = true;
    last_x = p.x();
  }
  return path;
}

// Ten times the usual step of x: nothing was there in between.
double usual_gap(const std::vector<Eigen::Vector2d>& points) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < points.size(); ++i)
    steps.push_back(points[i].x() - points[i - 1].x());
  if (steps.empty()) return 0.0;
  std::nth_element(steps.begin(), steps.begin() + static_cast<long>(steps.size() / 2), steps.end());
  return 10.0 * steps[steps.size() / 2];
}

std::string nothing(const std::string& title) {
  return "<p class=\"quiet\">" + escape_html(title) + ": nothing to show.</p>\n";
}

}  // namespace

std::string line_chart_svg(const LineChart& chart) {
  Range x{INFINITY, -INFINITY}, y{0.0, 0.0};
  for (const Series& series : chart.series)
    for (const Eigen::Vector2d& p : series.points) {
      if (!p.allFinite()) continue;
      x = {std::min(x.low, p.x()), std::max(x.high, p.x())};
      y = {std::min(y.low, p.y()), std::max(y.high, p.y())};
    }
  if (x.low > x.high) return nothing(chart.title);
  if (x.length() <= 0.0) x.high = x.low + 1.0;
  if (y.length() <= 0.0) y.high = 1.0;
  const Frame frame{x, rounded_out(y, 6)};
  std::string svg = begin(chart.title, frame, chart.x_label, chart.y_label);
  double legend = kLeft;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const Series& series = chart.series[i];
    const std::string color = std::to_string(i % 8 + 1);
    svg += "<path class=\"s" + color + "\" d=\"" +
           path_of(thinned(series.points), frame, chart.breaks ? usual_gap(series.points) : 0.0) +
           "\"/>\n";
    if (chart.series.size() == 1) continue;
    svg += "<path class=\"s" + color + " key\" d=\"M" + number(legend, 1) + " 25h14\"/>" +
           text_at(legend + 18, 29, "start", series.name) + "\n";
    legend += 32.0 + 6.6 * static_cast<double>(series.name.size());
  }
  return svg + "</svg>\n";
}

std::string histogram_svg(const Histogram& histogram) {
  std::vector<double> sorted;
  for (const double value : histogram.values)
    if (std::isfinite(value)) sorted.push_back(value);
  if (sorted.empty()) return nothing(histogram.title);
  std::sort(sorted.begin(), sorted.end());
  const double most =
      sorted[static_cast<std::size_t>(0.995 * static_cast<double>(sorted.size() - 1))];
  const double high = most > 0.0 ? most : 1.0;
  std::vector<std::size_t> bins(kBins);
  std::size_t beyond = 0;
  for (const double value : sorted) {
    if (value > high) ++beyond;
    ++bins[static_cast<std::size_t>(std::clamp(value / high * kBins, 0.0, kBins - 1.0))];
  }
  const auto tallest = static_cast<double>(*std::max_element(bins.begin(), bins.end()));
  const Frame frame{{0.0, high}, rounded_out({0.0, tallest}, 6)};
  std::string svg = begin(histogram.title, frame, histogram.x_label, "count");
  for (int i = 0; i < kBins; ++i) {
    const double left = frame.px(high * i / kBins), right = frame.px(high * (i + 1) / kBins);
    const double top = frame.py(static_cast<double>(bins[static_cast<std::size_t>(i)]));
    svg += "<rect class=\"bar\"" + at("x", left + 0.5) + at("y", top) +
           at("width", right - left - 1.0) + at("height", frame.py(0.0) - top) + "/>\n";
  }
  if (beyond > 0)
    svg += text_at(kWidth - kRight, 29, "end",
                   std::to_string(beyond) + " larger, up to " + number(sorted.back(), 3) +
                       ", counted in the last bar") +
           "\n";
  return svg + "</svg>\n";
}

}  // namespace fusion_slam
