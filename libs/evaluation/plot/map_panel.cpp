#include "libs/evaluation/plot/map_panel.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "libs/evaluation/plot/axes.hpp"

namespace fusion_slam {
namespace {

// Poses further apart in time are not joined by a line.
double longest_join_s(const Trajectory& trajectory) {
  return std::max(1.0, 3.0 * median_period_s(trajectory));
}

// Two axes of the world, horizontal and vertical on paper.
struct Plane {
  int horizontal = 0;
  int vertical = 1;
};

Range extent(const Trajectory& trajectory, int axis) {
  const double first = trajectory.front().T_world_body.translation()[axis];
  Range range{first, first};
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

// Both with a margin; never of no size.
Range extent_of_both(const Trajectory& a, const Trajectory& b, int axis) {
  const Range range_a = extent(a, axis);
  const Range range_b = extent(b, axis);
  const Range range{std::min(range_a.low, range_b.low), std::max(range_a.high, range_b.high)};
  const double margin = 0.05 * range.length() + 0.01;
  return {range.low - margin, range.high + margin};
}

class Map {
 public:
  Map(Canvas& canvas, const cv::Rect2d& area_px, const Trajectory& a, const Trajectory& b)
      : canvas_(canvas),
        plane_(choose_plane(a)),
        axes_(Axes::with_equal_scale(area_px, extent_of_both(a, b, plane_.horizontal),
                                     extent_of_both(a, b, plane_.vertical))) {}

  cv::Point2d at(const StampedPose& pose) const {
    const Eigen::Vector3d& p = pose.T_world_body.translation();
    return axes_.at(p[plane_.horizontal], p[plane_.vertical]);
  }

  void path(const Trajectory& trajectory, const Color& color, double width_px) {
    const double join_s = longest_join_s(trajectory);
    std::vector<cv::Point2d> points;
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
      if (i > 0 && trajectory[i].time_s - trajectory[i - 1].time_s > join_s) {
        canvas_.polyline(points, color, width_px);
        points.clear();
      }
      points.push_back(at(trajectory[i]));
    }
    canvas_.polyline(points, color, width_px);
  }

  void start(const StampedPose& pose) {
    canvas_.disc(at(pose), 6.0, colors::kInk);
    canvas_.disc(at(pose), 4.0, colors::kPaper);
  }

  void grid() { axes_.draw_grid(canvas_); }
  void frame() {
    const auto label = [](int axis) { return std::string(1, "xyz"[axis]) + " (m)"; };
    axes_.draw_frame(canvas_, label(plane_.horizontal), label(plane_.vertical));
  }

 private:
  Canvas& canvas_;
  Plane plane_;
  Axes axes_;
};

// What each matched pose shows: its own error, or that of the pair it is inside of or ends.
std::vector<std::optional<double>> error_of_poses(const TrajectoryError& result) {
  std::vector<std::optional<double>> errors(result.matched.size());
  std::size_t shown = 0;  // poses before this one have their error
  for (const ErrorSample& sample : result.samples) {
    for (std::size_t k = std::max(shown, sample.from); k <= sample.to; ++k) {
      errors[k] = sample.error;
    }
    shown = std::max(shown, sample.to + 1);
  }
  return errors;
}

void draw_colored_estimate(Canvas& canvas, const Map& map, const TrajectoryError& result,
                           const ColorScale& scale) {
  const Trajectory& estimate = result.matched.estimate;
  const double join_s = longest_join_s(estimate);
  const std::vector<std::optional<double>> errors = error_of_poses(result);
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    if (!errors[i]) continue;
    const bool joined = i > 0 && estimate[i].time_s - estimate[i - 1].time_s <= join_s;
    const cv::Point2d here = map.at(estimate[i]);
    canvas.line(joined ? map.at(estimate[i - 1]) : here, here, scale(*errors[i]), 3.0);
  }
}

void draw_legend(Canvas& canvas, const cv::Rect2d& area_px, const ColorScale& scale) {
  const TextStyle style{10.0, colors::kInk};
  const double y = area_px.y - 14.0;
  double x = area_px.x;
  canvas.line({x, y - 4.0}, {x + 34.0, y - 4.0}, colors::kReference, 2.0);
  canvas.text("reference", {x + 42.0, y}, style);
  x += 142.0;
  for (int i = 0; i < 34; ++i) {
    const double error = scale.range().low + scale.range().length() * i / 33.0;
    canvas.line({x + i, y - 4.0}, {x + i + 1.0, y - 4.0}, scale(error), 3.0);
  }
  canvas.text("estimate, coloured by its error", {x + 42.0, y}, style);
  x += 312.0;
  canvas.line({x, y - 4.0}, {x + 34.0, y - 4.0}, colors::kSoftInk, 1.0);
  canvas.text("estimate, not compared", {x + 42.0, y}, style);
  x += 250.0;
  canvas.disc({x + 6.0, y - 4.0}, 6.0, colors::kInk);
  canvas.disc({x + 6.0, y - 4.0}, 4.0, colors::kPaper);
  canvas.text("start", {x + 20.0, y}, style);
}

}  // namespace

void draw_map_panel(Canvas& canvas, const cv::Rect2d& area_px, const ErrorPlotData& data,
                    const ColorScale& scale) {
  const Trajectory estimate = transform(data.result.alignment, data.estimate);
  Map map(canvas, area_px, data.reference, estimate);
  map.grid();
  map.path(data.reference, colors::kReference, 2.0);
  map.path(estimate, colors::kSoftInk, 1.0);
  draw_colored_estimate(canvas, map, data.result, scale);
  map.start(estimate.front());
  map.frame();
  draw_legend(canvas, area_px, scale);
}

}  // namespace fusion_slam
