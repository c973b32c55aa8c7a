#include "libs/evaluation/plot/error_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "libs/evaluation/number_rows.hpp"
#include "libs/evaluation/plot/axes.hpp"
#include "libs/evaluation/plot/canvas.hpp"

namespace fusion_slam {
namespace {

constexpr int kWidth_px = 1400;
constexpr int kHeight_px = 1240;
const cv::Rect2d kMapArea(110, 108, 1110, 700);
const cv::Rect2d kBarArea(1262, 108, 22, 700);
const cv::Rect2d kTimeArea(110, 900, 1110, 260);
const Color kCurve(125, 82, 49);

// Two axes of the world, horizontal and vertical on paper.
struct Plane {
  int horizontal = 0;
  int vertical = 1;
};

Range extent(const Trajectory& trajectory, int axis) {
  Range range{trajectory.front().T_world_body.translation()[axis],
              trajectory.front().T_world_body.translation()[axis]};
  for (const StampedPose& pose : trajectory) {
    const double value = pose.T_world_body.translation()[axis];
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  }
  return range;
}

Plane choose_plane(const Trajectory& trajectory) {
  const double x = extent(trajectory, 0).length();
  const double y = extent(trajectory, 1).length();
  const double z = extent(trajectory, 2).length();
  if (2.0 * std::min(x, y) >= z) return {0, 1};
  return x < y ? Plane{1, 2} : Plane{0, 2};
}

// Both trajectories with a margin; never of no size.
Range extent_of_both(const Trajectory& a, const Trajectory& b, int axis) {
  const Range range_a = extent(a, axis);
  const Range range_b = extent(b, axis);
  const Range range{std::min(range_a.low, range_b.low), std::max(range_a.high, range_b.high)};
  const double margin = 0.05 * range.length() + 0.01;
  return {range.low - margin, range.high + margin};
}

// Viridis (perceptually even, readable when colour-blind) without its palest end, which white paper
// swallows; dark is a great error.
class ColorScale {
 public:
  explicit ColorScale(Range range) : range_(range) {
    cv::Mat ramp(256, 1, CV_8UC1);
    for (int i = 0; i < 256; ++i) ramp.at<uchar>(i) = static_cast<uchar>((255 - i) * 0.92);
    cv::applyColorMap(ramp, table_, cv::COLORMAP_VIRIDIS);
  }

  Color operator()(double error) const {
    const double share = std::clamp((error - range_.low) / range_.length(), 0.0, 1.0);
    const auto& bgr = table_.at<cv::Vec3b>(static_cast<int>(std::lround(share * 255.0)));
    return {double(bgr[0]), double(bgr[1]), double(bgr[2])};
  }
  const Range& range() const { return range_; }

 private:
  Range range_;
  cv::Mat table_;
};

// What each matched pose shows: its own error, or that of the pair it is inside of or ends.
std::vector<std::optional<double>> error_of_poses(const TrajectoryError& result) {
  std::vector<std::optional<double>> errors(result.matched.size());
  std::size_t covered = 0;  // poses before this one have their error
  for (const ErrorSample& sample : result.samples) {
    for (std::size_t k = std::max(covered, sample.from); k <= sample.to; ++k) {
      errors[k] = sample.error;
    }
    covered = std::max(covered, sample.to + 1);
  }
  return errors;
}

std::string axis_label(int axis) { return std::string(1, "xyz"[axis]) + " (m)"; }

cv::Point2d project(const Axes& axes, const Plane& plane, const StampedPose& pose) {
  const Eigen::Vector3d& p = pose.T_world_body.translation();
  return axes.at(p[plane.horizontal], p[plane.vertical]);
}

void draw_map(Canvas& canvas, const TrajectoryError& result, const Trajectory& reference,
              const ColorScale& scale) {
  const Trajectory& estimate = result.matched.estimate;
  const Plane plane = choose_plane(reference);
  const Axes axes =
      Axes::with_equal_scale(kMapArea, extent_of_both(reference, estimate, plane.horizontal),
                             extent_of_both(reference, estimate, plane.vertical));
  axes.draw_grid(canvas);
  std::vector<cv::Point2d> path;
  for (const StampedPose& pose : reference) path.push_back(project(axes, plane, pose));
  canvas.polyline(path, colors::kReference, 1.6);

  const std::vector<std::optional<double>> errors = error_of_poses(result);
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const Color color = errors[i] ? scale(*errors[i]) : colors::kSoftInk;
    const cv::Point2d here = project(axes, plane, estimate[i]);
    const bool joined = i > 0 && estimate[i].time_s - estimate[i - 1].time_s <=
                                     std::max(1.0, result.coverage.allowed_gap_s);
    if (joined) {
      canvas.line(project(axes, plane, estimate[i - 1]), here, color, 2.6);
    } else {
      canvas.disc(here, 2.0, color);
    }
  }
  canvas.disc(project(axes, plane, estimate.front()), 6.0, colors::kInk);
  canvas.disc(project(axes, plane, estimate.front()), 4.0, {255, 255, 255});
  axes.draw_frame(canvas, axis_label(plane.horizontal), axis_label(plane.vertical));
}

void draw_map_legend(Canvas& canvas, const ColorScale& scale) {
  const TextStyle style{10.0, colors::kInk};
  const double y = kMapArea.y - 14.0;
  double x = kMapArea.x;
  canvas.line({x, y - 4.0}, {x + 34.0, y - 4.0}, colors::kReference, 2.0);
  canvas.text("reference", {x + 42.0, y}, style);
  x += 142.0;
  for (int i = 0; i < 34; ++i) {
    const double error = scale.range().low + scale.range().length() * i / 33.0;
    canvas.line({x + i, y - 4.0}, {x + i + 1.0, y - 4.0}, scale(error), 3.0);
  }
  canvas.text("estimate, coloured by its error", {x + 42.0, y}, style);
  x += 310.0;
  canvas.disc({x + 6.0, y - 4.0}, 6.0, colors::kInk);
  canvas.disc({x + 6.0, y - 4.0}, 4.0, {255, 255, 255});
  canvas.text("start", {x + 20.0, y}, style);
}

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " (" + unit + ")";
}

void draw_color_bar(Canvas& canvas, const ColorScale& scale, const ErrorPlotText& text) {
  const Axes axes(kBarArea, {0.0, 1.0}, scale.range());
  for (int row = 0; row < static_cast<int>(kBarArea.height); ++row) {
    const double share = 1.0 - (row + 0.5) / kBarArea.height;
    canvas.fill({kBarArea.x, kBarArea.y + row, kBarArea.width, 1.0},
                scale(scale.range().low + share * scale.range().length()));
  }
  canvas.frame(kBarArea, colors::kFrame, 1.0);
  const std::vector<double> values = ticks(scale.range(), 10);
  const std::vector<std::string> labels = tick_labels(values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    canvas.text(labels[i], {kBarArea.x + kBarArea.width + 8.0, axes.at(0, values[i]).y + 4.5},
                {9.5, colors::kSoftInk});
  }
  canvas.vertical_text(with_unit(text.error_name, text.unit),
                       {kWidth_px - 16.0, kBarArea.y + kBarArea.height / 2.0},
                       {10.5, colors::kInk});
}

// The bands of time in the window that coverage does not count.
std::vector<Range> uncovered(const TrajectoryError& result, const Trajectory& covering) {
  const Coverage& coverage = result.coverage;
  std::vector<Range> bands;
  double from_s = coverage.window.begin_s;
  for (std::size_t i = 0; i <= covering.size(); ++i) {
    const bool end = i == covering.size();
    const double to_s = end ? coverage.window.end_s : covering[i].time_s;
    const bool edge = end || i == 0;
    const double allowed_s = edge ? 0.0 : coverage.allowed_gap_s;
    if (to_s - from_s > allowed_s) {
      bands.push_back(
          {std::max(from_s, coverage.window.begin_s), std::min(to_s, coverage.window.end_s)});
    }
    from_s = to_s;
  }
  return bands;
}

void draw_over_time(Canvas& canvas, const TrajectoryError& result, const ColorScale& scale,
                    const ErrorPlotText& text) {
  const Trajectory& estimate = result.matched.estimate;
  const TimeWindow& window = result.coverage.window;
  const double start_s = std::min(window.begin_s, estimate.front().time_s);
  const double end_s = std::max({window.end_s, estimate.back().time_s, start_s + 1e-3});
  const Axes axes(kTimeArea, {0.0, end_s - start_s}, scale.range());
  const double top = axes.y().high;
  const double bottom = axes.y().low;
  bool any_gap = false;
  for (const Range& band : uncovered(result, estimate)) {
    if (band.length() <= 0.0) continue;
    any_gap = true;
    canvas.fill(cv::Rect2d(axes.at(band.low - start_s, top), axes.at(band.high - start_s, bottom)),
                colors::kGap);
  }
  axes.draw_grid(canvas);
  std::vector<cv::Point2d> curve;
  double last_s = estimate.front().time_s;
  const double break_s = std::max(1.0, result.coverage.allowed_gap_s);
  const bool each_pose = result.samples.size() + 1 >= estimate.size();
  for (const ErrorSample& sample : result.samples) {
    const double time_s = estimate[sample.to].time_s;
    const cv::Point2d here = axes.at(time_s - start_s, sample.error);
    if (time_s < last_s) continue;  // all pairs: ends may come in another order than starts
    if (each_pose && time_s - last_s > break_s) {
      canvas.polyline(curve, kCurve, 1.2);
      curve.clear();
    }
    if (!each_pose) canvas.disc(here, 1.8, kCurve);
    curve.push_back(here);
    last_s = time_s;
  }
  canvas.polyline(curve, kCurve, each_pose ? 1.2 : 0.8);

  const Statistics& s = result.statistics;
  const double right = axes.x().high;
  const std::array<std::pair<const char*, double>, 2> levels = {
      {{"RMSE", s.rmse}, {"median", s.median}}};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const cv::Point2d end = axes.at(right, levels[i].second);
    const cv::Point2d from = axes.at(0.0, levels[i].second);
    if (i == 0) {
      canvas.line(from, end, colors::kInk, 1.2);
    } else {
      canvas.dashed_line(from, end, colors::kInk, 1.0);
    }
  }
  // Labels beside the lines, pushed apart when the two are close.
  double rmse_y = axes.at(0, s.rmse).y + 4.5;
  double median_y = std::max(axes.at(0, s.median).y + 4.5, rmse_y + 16.0);
  if (s.median > s.rmse) median_y = std::min(axes.at(0, s.median).y + 4.5, rmse_y - 16.0);
  std::array<char, 64> label{};
  std::snprintf(label.data(), label.size(), "RMSE %.4g %s", s.rmse, text.unit.c_str());
  const double label_x = kTimeArea.x + kTimeArea.width + 10.0;
  canvas.text(label.data(), {label_x, rmse_y}, {9.5, colors::kInk});
  std::snprintf(label.data(), label.size(), "median %.4g %s", s.median, text.unit.c_str());
  canvas.text(label.data(), {label_x, median_y}, {9.5, colors::kInk});
  if (any_gap) {
    const double x = kTimeArea.x + kTimeArea.width;
    const double width = Canvas::text_width("no estimate", {9.5});
    canvas.fill({x - width - 32.0, kTimeArea.y - 22.0, 22.0, 12.0}, colors::kGap);
    canvas.frame({x - width - 32.0, kTimeArea.y - 22.0, 22.0, 12.0}, colors::kFrame, 0.5);
    canvas.text("no estimate", {x - width - 3.0, kTimeArea.y - 11.0}, {9.5, colors::kSoftInk});
  }
  axes.draw_frame(canvas, "time since the start (s)", with_unit(text.error_name, text.unit));
}

}  // namespace

cv::Mat draw_error_plot(const TrajectoryError& result, const Trajectory& reference,
                        const ErrorPlotText& text) {
  Canvas canvas(kWidth_px, kHeight_px);
  const double top = std::max(result.statistics.max, 1e-9);
  const ColorScale scale(rounded_out({0.0, top}, 10));
  canvas.text(text.title, {kMapArea.x, 40.0}, {17.0, colors::kInk, Anchor::kLeft, true});
  canvas.text(text.subtitle, {kMapArea.x, 66.0}, {10.5, colors::kSoftInk});
  draw_map_legend(canvas, scale);
  draw_map(canvas, result, reference, scale);
  draw_color_bar(canvas, scale, text);
  draw_over_time(canvas, result, scale, text);
  return canvas.image();
}

void write_png(const std::filesystem::path& file, const cv::Mat& image) {
  if (file.extension() != ".png") throw FileError(file.string(), "a plot's name must end in .png");
  std::vector<uchar> bytes;
  cv::imencode(".png", image, bytes);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw FileError(file.string(), "can't be written; does the folder exist, is it full?");
}

}  // namespace fusion_slam
