#include "libs/scan_matching/thinning.hpp"

#include <cmath>
#include <set>
#include <utility>

namespace fusion_slam {

Points thinned(const Points& points, int most) {
  Points kept = points;
  for (double edge_m = 0.05; kept.size() > static_cast<std::size_t>(most); edge_m *= 1.3) {
    kept.clear();
    std::set<std::pair<int, int>> cells;
    for (const auto& p : points)
      if (cells
              .emplace(static_cast<int>(std::floor(p.x() / edge_m)),
                       static_cast<int>(std::floor(p.y() / edge_m)))
              .second)
        kept.push_back(p);
  }
  return kept;
}

}  // namespace fusion_slam
