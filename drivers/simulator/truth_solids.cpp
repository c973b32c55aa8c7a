#include "drivers/simulator/truth_solids.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

using Polygon = std::vector<Eigen::Vector3d>;

double cross(const Eigen::Vector3d& o, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

// Monotone chain (Andrew 1979), counter-clockwise, on the floor.
Polygon hull_on_floor(Polygon points) {
  for (Eigen::Vector3d& p : points) p.z() = 0.0;
  std::sort(points.begin(), points.end(), [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  Polygon hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = hull.size();
    for (const Eigen::Vector3d& p : points) {
      while (hull.size() >= begin + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0.0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

Footprint with_heights(Polygon polygon, ObstacleClass obstacle) {
  Footprint footprint;
  footprint.obstacle = obstacle;
  footprint.low_m = footprint.high_m = polygon.front().z();
  for (const Eigen::Vector3d& p : polygon) {
    footprint.low_m = std::min(footprint.low_m, p.z());
    footprint.high_m = std::max(footprint.high_m, p.z());
  }
  footprint.outline_m = std::move(polygon);
  return footprint;
}

Polygon clip_to_band(const Polygon& polygon, const HeightBand& band) {
  return clip(clip(polygon, 2, -1.0, band.low_m), 2, 1.0, band.high_m);
}

}  // namespace

std::vector<Eigen::Vector3d> clip(const std::vector<Eigen::Vector3d>& polygon, int axis,
                                  double sign, double limit) {
  std::vector<Eigen::Vector3d> inside;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d& a = polygon[i];
    const Eigen::Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double over_a = sign * (a[axis] - limit);
    const double over_b = sign * (b[axis] - limit);
    if (over_a <= 0.0) inside.push_back(a);
    if ((over_a < 0.0 && over_b > 0.0) || (over_a > 0.0 && over_b < 0.0)) {
      inside.push_back(a + over_a / (over_a - over_b) * (b - a));
      inside.back()[axis] = limit;
    }
  }
  return inside;
}

std::optional<Footprint> footprint_of(const Box& box, const HeightBand& band) {
  Polygon corners;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign((i & 1) * 2 - 1, (i >> 1 & 1) * 2 - 1, (i >> 2 & 1) * 2 - 1);
    corners.emplace_back(box.T_world_box * box.half_m.cwiseProduct(sign));
  }
  // The faces, cut to the band, have all corners of the cut box.
  Polygon within;
  for (int axis = 0; axis < 3; ++axis) {
    const int one = 1 << ((axis + 1) % 3), other = 1 << ((axis + 2) % 3);
    for (const int base : {0, 1 << axis}) {
      const auto corner = [&](int i) { return corners[static_cast<std::size_t>(i)]; };
      const Polygon face = {corner(base), corner(base | one), corner(base | one | other),
                            corner(base | other)};
      const Polygon cut = clip_to_band(face, band);
      within.insert(within.end(), cut.begin(), cut.end());
    }
  }
  if (within.empty()) return std::nullopt;
  Footprint footprint = with_heights(within, box.obstacle);
  // What only touches the band from above or below is no obstacle.
  if (footprint.high_m <= band.low_m || footprint.low_m >= band.high_m) return std::nullopt;
  footprint.outline_m = hull_on_floor(std::move(within));
  return footprint;
}

std::optional<Footprint> footprint_of(const TruthTriangle& triangle, const HeightBand& band) {
  Polygon within =
      clip_to_band({triangle.corners_m[0], triangle.corners_m[1], triangle.corners_m[2]}, band);
  if (within.empty()) return std::nullopt;
  Footprint footprint = with_heights(std::move(within), triangle.obstacle);
  if (footprint.high_m <= band.low_m || footprint.low_m >= band.high_m) return std::nullopt;
  footprint.surface = true;
  return footprint;
}

}  // namespace fusion_slam
