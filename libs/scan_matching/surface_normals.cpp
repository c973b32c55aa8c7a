#include "libs/scan_matching/surface_normals.hpp"

#include <cmath>
#include <cstddef>

namespace fusion_slam {
namespace {

constexpr double kBaseline_m = 0.2;  // shorter, and the ranges' noise turns the normal
constexpr std::size_t kReach = 24;   // points
constexpr double kStraight = 0.94;   // cosine of the bend at the point: 20 degrees
constexpr double kStretch = 0.1;  // a gap wider than twice the baseline and this part of the range
                                  // may be the end of what is seen of a wall

}  // namespace

Points surface_normals(const Points& points, const Eigen::Vector2d& origin) {
  Points normals(points.size(), Eigen::Vector2d::Zero());
  const std::size_t none = points.size();
  // The first point at least a baseline away in direction `step`.
  const auto neighbour = [&](std::size_t i, std::size_t step) {
    std::size_t k = i;
    for (std::size_t n = 0; n < kReach; ++n) {
      k += step;  // below 0 wraps to a number past the end
      if (k >= points.size()) break;
      if ((points[k] - points[i]).norm() >= kBaseline_m) return k;
    }
    return none;
  };
  const auto straight = [&](std::size_t a, std::size_t b, std::size_t c) {
    return (points[b] - points[a]).normalized().dot((points[c] - points[b]).normalized()) >=
           kStraight;
  };
  const auto apart = [&](std::size_t a, std::size_t b) {
    return (points[a] - points[b]).norm() >
           2.0 * kBaseline_m + kStretch * (points[a] - origin).norm();
  };
  constexpr auto kBack = static_cast<std::size_t>(-1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::size_t before = neighbour(i, kBack), after = neighbour(i, 1);
    if (before == none && after == none) continue;
    if (before == none || after == none || !straight(before, i, after)) {
      // A corner is a mark of the wall's own. But where the view of a wall ends, by range or
      // because something stands before it, moves with the robot: it must not look like a corner.
      const bool ends_before = before == none || apart(i, before);
      const bool ends_after = after == none || apart(i, after);
      if (ends_before == ends_after) continue;
      const std::size_t step = ends_before ? 1 : kBack;
      const std::size_t other = ends_before ? after : before;
      const std::size_t beyond = neighbour(other, step);
      if (beyond == none || !straight(i, other, beyond)) continue;
      before = ends_before ? i : beyond;
      after = ends_before ? beyond : i;
    }
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (std::size_t k = before; k <= after; ++k) mean += points[k];
    mean /= static_cast<double>(after - before + 1);
    double xx = 0.0, xy = 0.0, yy = 0.0;
    for (std::size_t k = before; k <= after; ++k) {
      const Eigen::Vector2d d = points[k] - mean;
      xx += d.x() * d.x(), xy += d.x() * d.y(), yy += d.y() * d.y();
    }
    const double along = 0.5 * std::atan2(2.0 * xy, xx - yy);  // main axis of the scatter
    Eigen::Vector2d normal(-std::sin(along), std::cos(along));
    if (normal.dot(origin - points[i]) < 0.0) normal = -normal;
    normals[i] = normal;
  }
  return normals;
}

}  // namespace fusion_slam
