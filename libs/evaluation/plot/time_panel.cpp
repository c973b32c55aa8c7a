#include "libs/evaluation/plot/time_panel.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

namespace fusion_slam {
namespace {

const Color kCurve(125, 82, 49);
const TextStyle kLabel{9.5, colors::kInk};
constexpr double kLabelHeight_px = 16.0;
// Fewer errors than this are shown as points too.
constexpr std::size_t kFewSamples = 200;

// The whole question and all of the answer.
TimeWindow shown_window(const TrajectoryError& result) {
  const Trajectory& estimate = result.matched.estimate;
  const TimeWindow& asked = result.coverage.window;
  const double begin_s = std::min(asked.begin_s, estimate.front().time_s);
  return {begin_s, std::max({asked.end_s, estimate.back().time_s, begin_s + 1e-3})};
}

void draw_lost(Canvas& canvas, const Axes& axes, double start_s,
               const std::vector<TimeWindow>& lost) {
  if (lost.empty()) return;
  for (const TimeWindow& time : lost) {
    canvas.fill(cv::Rect2d(axes.at(time.begin_s - start_s, axes.y().high),
                           axes.at(time.end_s - start_s, axes.y().low)),
                colors::kGap);
  }
  const std::string text = "no estimate";
  const double x = axes.area().x + axes.area().width - Canvas::text_width(text, kLabel);
  const cv::Rect2d sample(x - 30.0, axes.area().y - 22.0, 22.0, 12.0);
  canvas.fill(sample, colors::kGap);
  canvas.frame(sample, colors::kFrame, 0.5);
  canvas.text(text, {x, axes.area().y - 11.0}, kLabel);
}

// An error stands at the time of the later pose of its pair. A line joins neighbours, but not
// across lost time where each pose has an error.
void draw_errors(Canvas& canvas, const Axes& axes, double start_s, const TrajectoryError& result) {
  const double join_s = std::max(1.0, 3.0 * median_period_s(result.matched.estimate));
  const bool few = result.samples.size() < kFewSamples;
  std::vector<std::pair<double, double>> points;
  for (const ErrorSample& sample : result.samples) {
    points.emplace_back(result.matched.estimate[sample.to].time_s, sample.error);
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<cv::Point2d> curve;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [time_s, error] = points[i];
    if (i > 0 && !few && time_s - points[i - 1].first > join_s) {
      canvas.polyline(curve, kCurve, 1.2);
      curve.clear();
    }
    curve.push_back(axes.at(time_s - start_s, error));
    if (few) canvas.disc(curve.back(), 2.5, kCurve);
  }
  canvas.polyline(curve, kCurve, 1.2);
}

std::string level_label(const char* name, double level, const std::string& unit) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%s %.4g %s", name, level, unit.c_str());
  return text.data();
}

// RMSE and median as lines, named on the right; the two names make room for each other.
void draw_levels(Canvas& canvas, const Axes& axes, const Statistics& statistics,
                 const std::string& unit) {
  const auto at = [&](double x, double level) { return axes.at(x, level); };
  const double right = axes.x().high;
  canvas.line(at(0.0, statistics.rmse), at(right, statistics.rmse), colors::kInk, 1.2);
  canvas.dashed_line(at(0.0, statistics.median), at(right, statistics.median), colors::kInk, 1.0);
  const double rmse_y = at(0.0, statistics.rmse).y + 4.5;
  double median_y = at(0.0, statistics.median).y + 4.5;
  median_y = statistics.median > statistics.rmse ? std::min(median_y, rmse_y - kLabelHeight_px)
                                                 : std::max(median_y, rmse_y + kLabelHeight_px);
  const double x = axes.area().x + axes.area().width + 10.0;
  canvas.text(level_label("RMSE", statistics.rmse, unit), {x, rmse_y}, kLabel);
  canvas.text(level_label("median", statistics.median, unit), {x, median_y}, kLabel);
}

}  // namespace

void draw_time_panel(Canvas& canvas, const cv::Rect2d& area_px, const ErrorPlotData& data,
                     const Range& error_range, const std::string& error_label) {
  const TimeWindow window = shown_window(data.result);
  const Axes axes(area_px, {0.0, window.length_s()}, error_range);
  draw_lost(canvas, axes, window.begin_s, data.result.coverage.lost);
  axes.draw_grid(canvas);
  draw_errors(canvas, axes, window.begin_s, data.result);
  draw_levels(canvas, axes, data.result.statistics, data.text.unit);
  axes.draw_frame(canvas, "time since the start (s)", error_label);
}

}  // namespace fusion_slam
