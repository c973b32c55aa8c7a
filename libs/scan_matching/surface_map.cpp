#include "libs/scan_matching/surface_map.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace fusion_slam {
namespace {

constexpr double kSameSide = 0.7;  // cosine of 45 degrees
constexpr int kMostWeight = 60;    // beyond this a surface follows what is seen now

}  // namespace

void SurfaceMap::add(const Points& points, const Points& normals) {
  CellIndex low{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
  CellIndex high{std::numeric_limits<int>::min(), std::numeric_limits<int>::min()};
  bool any = false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (normals[i].isZero()) continue;
    const CellIndex c = first_.cell_of(points[i].x(), points[i].y());
    low = {std::min(low.x, c.x), std::min(low.y, c.y)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y)};
    any = true;
  }
  if (!any) return;
  first_.include(low, high);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (normals[i].isZero()) continue;
    const CellIndex c = first_.cell_of(points[i].x(), points[i].y());
    std::int32_t* link = &first_.cell(c.x, c.y);
    int at = *link;
    while (at >= 0) {
      const Slot& slot = slots_[static_cast<std::size_t>(at)];
      if (slot.surface.normal.dot(normals[i]) > kSameSide) break;
      at = slot.next;
    }
    if (at < 0) {  // first of its kind in this square
      at = static_cast<int>(slots_.size());
      slots_.push_back({});
      slots_.back().next = *link;
      *link = at;
    }
    Slot& slot = slots_[static_cast<std::size_t>(at)];
    Surface& s = slot.surface;
    if (s.weight < kMostWeight)
      ++s.weight;
    else
      slot.normal_sum *= 1.0 - 1.0 / kMostWeight;
    s.point += (points[i] - s.point) / s.weight;
    slot.normal_sum += normals[i];
    s.normal = slot.normal_sum.normalized();
  }
}

const Surface* SurfaceMap::find(const Eigen::Vector2d& point, const Eigen::Vector2d& normal) const {
  const CellIndex c = first_.cell_of(point.x(), point.y());
  const Surface* best = nullptr;
  double nearest = std::numeric_limits<double>::infinity();
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      for (int at = first_.at(c.x + dx, c.y + dy); at >= 0;) {
        const Slot& slot = slots_[static_cast<std::size_t>(at)];
        at = slot.next;
        if (slot.surface.normal.dot(normal) < kSameSide) continue;
        const double d = (slot.surface.point - point).squaredNorm();
        if (d < nearest) nearest = d, best = &slot.surface;
      }
  return best;
}

}  // namespace fusion_slam
