#include "services/lidar_mapper/voxel_filter.hpp"

#include <cmath>
#include <cstdint>
#include <numeric>

namespace fusion_slam {

std::vector<std::size_t> voxel_indices(const Points& points, double edge_m) {
  std::vector<std::size_t> kept;
  std::vector<std::uint64_t> keys;  // of the kept
  // Hash table of 1 + place among the kept; at most half full, so that chains stay short.
  std::size_t capacity = 64;
  while (capacity < 2 * points.size()) capacity *= 2;
  std::vector<std::uint32_t> table(capacity, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto x = static_cast<std::int32_t>(std::floor(points[i].x() / edge_m));
    const auto y = static_cast<std::int32_t>(std::floor(points[i].y() / edge_m));
    const std::uint64_t key = (std::uint64_t{static_cast<std::uint32_t>(x)} << 32U) |
                              std::uint64_t{static_cast<std::uint32_t>(y)};
    std::size_t at = (key * 0x9E3779B97F4A7C15U >> 20U) & (capacity - 1);
    while (table[at] != 0 && keys[table[at] - 1] != key) at = (at + 1) & (capacity - 1);
    if (table[at] != 0) continue;
    kept.push_back(i);
    keys.push_back(key);
    table[at] = static_cast<std::uint32_t>(kept.size());
  }
  return kept;
}

std::vector<std::size_t> adaptive_voxel_indices(const Points& points, double max_edge_m,
                                                int min_points) {
  const auto enough = [&](const std::vector<std::size_t>& kept) {
    return kept.size() >= static_cast<std::size_t>(min_points);
  };
  std::vector<std::size_t> all(points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  if (!enough(all)) return all;
  std::vector<std::size_t> best = voxel_indices(points, max_edge_m);
  if (enough(best)) return best;
  best = std::move(all);
  double few = max_edge_m, many = 0.0;  // edges that leave too few and enough points
  for (int i = 0; i < 6; ++i) {
    const double edge = 0.5 * (few + many);
    std::vector<std::size_t> thinned = voxel_indices(points, edge);
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
