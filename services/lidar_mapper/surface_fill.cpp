#include "services/lidar_mapper/surface_fill.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

// Flattest incidence at which neighbours still count as one surface: 1 / sin.
constexpr double kMostStretch = 12.0;

// Does c, beyond a as seen from b, continue the line from b to a?
bool continues(const Eigen::Vector2d& c, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
               double noise_m) {
  const Eigen::Vector2d line = (a - b), next = c - a;
  const double gap = line.norm(), length = next.norm();
  if (length < gap / 3.0 || length > 3.0 * gap) return false;  // spacing changes slowly on a plane
  const double along = next.dot(line) / gap;
  const double across = std::abs(line.x() * next.y() - line.y() * next.x()) / gap;
  return along > 0.0 && across <= 0.2 * length + noise_m;
}

}  // namespace

Points fill_surfaces(const Points& hits, const Eigen::Vector2d& origin, double radstep_rad,
                     double spacing_m, double noise_m) {
  Points filled;
  for (std::size_t i = 0; i + 1 < hits.size(); ++i) {
    const Eigen::Vector2d &a = hits[i], &b = hits[i + 1];
    const double gap = (b - a).norm();
    const double nearest = std::min((a - origin).norm(), (b - origin).norm());
    if (gap <= spacing_m || gap > kMostStretch * nearest * std::abs(radstep_rad)) continue;
    const bool before = i > 0 && continues(hits[i - 1], a, b, noise_m);
    const bool after = i + 2 < hits.size() && continues(hits[i + 2], b, a, noise_m);
    if (!before && !after) continue;
    const int pieces = static_cast<int>(std::ceil(gap / spacing_m));
    for (int k = 1; k < pieces; ++k) filled.push_back(a + (b - a) * k / pieces);
  }
  return filled;
}

}  // namespace fusion_slam
