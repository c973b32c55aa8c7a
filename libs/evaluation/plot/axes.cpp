#include "libs/evaluation/plot/axes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace fusion_slam {
namespace {

constexpr double kXTickSpacing_px = 90.0;
constexpr double kYTickSpacing_px = 55.0;
const TextStyle kTickText{9.5, colors::kSoftInk};
const TextStyle kAxisText{10.5, colors::kInk};

double tick_step(double length, int max_count) {
  const double least = length / std::max(1, max_count);
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

Range grown(const Range& range, double length) {
  const double middle = 0.5 * (range.low + range.high);
  return {middle - 0.5 * length, middle + 0.5 * length};
}

TextStyle anchored(TextStyle style, Anchor anchor) {
  style.anchor = anchor;
  return style;
}

}  // namespace

std::vector<double> ticks(const Range& range, int max_count) {
  const double step = tick_step(range.length(), max_count);
  std::vector<double> values;
  const double first = std::ceil(range.low / step - 1e-6);
  for (double k = first; k * step <= range.high + 1e-6 * step; k += 1.0) {
    values.push_back(k == 0.0 ? 0.0 : k * step);
  }
  return values;
}

std::vector<std::string> tick_labels(const std::vector<double>& values) {
  const double step = values.size() > 1 ? values[1] - values[0] : 1.0;
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-6)));
  std::vector<std::string> labels;
  for (const double value : values) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
    labels.emplace_back(text.data());
  }
  return labels;
}

Range rounded_out(const Range& range, int max_count) {
  const double step = tick_step(range.length(), max_count);
  return {std::floor(range.low / step + 1e-9) * step, std::ceil(range.high / step - 1e-9) * step};
}

Axes Axes::with_equal_scale(cv::Rect2d area_px, Range x, Range y) {
  const double unit_per_px = std::max(x.length() / area_px.width, y.length() / area_px.height);
  return {area_px, grown(x, unit_per_px * area_px.width), grown(y, unit_per_px * area_px.height)};
}

cv::Point2d Axes::at(double x, double y) const {
  return {area_.x + (x - x_.low) / x_.length() * area_.width,
          area_.y + area_.height - (y - y_.low) / y_.length() * area_.height};
}

std::vector<double> Axes::x_ticks() const {
  return ticks(x_, static_cast<int>(area_.width / kXTickSpacing_px));
}

std::vector<double> Axes::y_ticks() const {
  return ticks(y_, static_cast<int>(area_.height / kYTickSpacing_px));
}

void Axes::draw_grid(Canvas& canvas) const {
  for (const double x : x_ticks()) canvas.line(at(x, y_.low), at(x, y_.high), colors::kGrid, 1.0);
  for (const double y : y_ticks()) canvas.line(at(x_.low, y), at(x_.high, y), colors::kGrid, 1.0);
}

void Axes::draw_frame(Canvas& canvas, const std::string& x_label,
                      const std::string& y_label) const {
  canvas.frame(area_, colors::kFrame, 1.0);
  const double bottom = area_.y + area_.height;
  const std::vector<double> xs = x_ticks();
  const std::vector<std::string> x_texts = tick_labels(xs);
  for (std::size_t i = 0; i < xs.size(); ++i) {
    canvas.text(x_texts[i], {at(xs[i], y_.low).x, bottom + 18.0},
                anchored(kTickText, Anchor::kCenter));
  }
  const std::vector<double> ys = y_ticks();
  const std::vector<std::string> y_texts = tick_labels(ys);
  for (std::size_t i = 0; i < ys.size(); ++i) {
    canvas.text(y_texts[i], {area_.x - 8.0, at(x_.low, ys[i]).y + 4.5},
                anchored(kTickText, Anchor::kRight));
  }
  canvas.text(x_label, {area_.x + area_.width / 2.0, bottom + 40.0},
              anchored(kAxisText, Anchor::kCenter));
  canvas.vertical_text(y_label, {area_.x - 58.0, area_.y + area_.height / 2.0}, kAxisText);
}

}  // namespace fusion_slam
