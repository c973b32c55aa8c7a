#include "services/lidar_mapper/voxel_filter.hpp"

#include <cmath>
#include <set>
#include <utility>

namespace fusion_slam {

Points voxel_filter(const Points& points, double edge_m) {
  Points kept;
  std::set<std::pair<int, int>> seen;
  for (const auto& p : points) {
    const auto x = static_cast<int>(std::floor(p.x() / edge_m));
    const auto y = static_cast<int>(std::floor(p.y() / edge_m));
    if (seen.emplace(x, y).second) kept.push_back(p);
  }
  return kept;
}

Points adaptive_voxel_filter(const Points& points, double max_edge_m, int min_points) {
  const auto enough = [&](const Points& p) {
    return p.size() >= static_cast<std::size_t>(min_points);
  };
  if (!enough(points)) return points;
  Points best = voxel_filter(points, max_edge_m);
  if (enough(best)) return best;
  best = points;
  double few = max_edge_m, many = 0.0;  // edges that leave too few and enough points
  for (int i = 0; i < 6; ++i) {
    const double edge = 0.5 * (few + many);
    Points thinned = voxel_filter(points, edge);
    if (enough(thinned)) {
      many = edge;
      best = std::move(thinned);
    } else {
      few = edge;
    }
  }
  return best;
}

}  // namespace fusion_slam
