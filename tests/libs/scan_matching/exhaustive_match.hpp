// match_correlative()'s question, answered by trying everything.
#pragma once

#include <algorithm>
#include <cmath>

#include "libs/scan_matching/correlative_matcher.hpp"

namespace fusion_slam {

inline double best_score_by_force(const Raster& raster, const Points& points, const SE2& predicted,
                                  const SearchWindow& window) {
  const double res = raster.resolution_m();
  const int radius = static_cast<int>(std::ceil(window.linear_m / res - 1e-9));
  const int half =
      static_cast<int>(std::ceil(window.angular_rad / angular_step(points, res) - 1e-9));
  double best = -1.0;
  for (int a = -half; a <= half; ++a)
    for (int dx = -radius; dx <= radius; ++dx)
      for (int dy = -radius; dy <= radius; ++dy) {
        const SE2 T{predicted.x, predicted.y, predicted.yaw + a * window.angular_rad / half};
        double sum = 0.0;
        for (const auto& p : points) {
          const Eigen::Vector2d q = T * p;
          sum += match_byte(raster.at(static_cast<int>(std::floor(q.x() / res)) + dx,
                                      static_cast<int>(std::floor(q.y() / res)) + dy)) /
                 255.0;
        }
        const auto square = [](double v) { return v * v; };
        best = std::max(best, sum / static_cast<double>(points.size()) -
                                  window.edge_penalty * (square(static_cast<double>(dx) / radius) +
                                                         square(static_cast<double>(dy) / radius) +
                                                         square(static_cast<double>(a) / half)));
      }
  return best;
}

}  // namespace fusion_slam
