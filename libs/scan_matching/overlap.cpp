#include "libs/scan_matching/overlap.hpp"

namespace fusion_slam {

Overlap measure_overlap(const Raster& raster, const Points& points_base, const SE2& T_grid_base) {
  const std::uint8_t even = cell_from_probability(0.5);
  Overlap overlap;
  overlap.n_points = static_cast<int>(points_base.size());
  for (const auto& p : points_base) {
    const Eigen::Vector2d q = T_grid_base * p;
    const CellIndex c = raster.cell_of(q.x(), q.y());
    bool known = false, matched = false;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const std::uint8_t cell = raster.at(c.x + dx, c.y + dy);
        known = known || cell != kUnknownCell;
        matched = matched || cell > even;
      }
    overlap.n_known += known ? 1 : 0;
    overlap.n_matched += matched ? 1 : 0;
  }
  return overlap;
}

std::vector<std::size_t> indices_in_known_space(const Raster& raster, const Points& points_base,
                                                const SE2& T_grid_base, int reach) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < points_base.size(); ++i) {
    const Eigen::Vector2d q = T_grid_base * points_base[i];
    const CellIndex c = raster.cell_of(q.x(), q.y());
    bool found = raster.at(c.x, c.y) != kUnknownCell;  // nearly always
    for (int dy = -reach; dy <= reach && !found; ++dy)
      for (int dx = -reach; dx <= reach && !found; ++dx)
        found = raster.at(c.x + dx, c.y + dy) != kUnknownCell;
    if (found) known.push_back(i);
  }
  return known;
}

Points points_in_known_space(const Raster& raster, const Points& points_base,
                             const SE2& T_grid_base, int reach) {
  Points known;
  for (const std::size_t i : indices_in_known_space(raster, points_base, T_grid_base, reach))
    known.push_back(points_base[i]);
  return known;
}

}  // namespace fusion_slam
