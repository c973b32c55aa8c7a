#include "libs/places/rival_match.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace fusion_slam {
namespace {

class RivalSearch {
 public:
  RivalSearch(const SearchPyramid& pyramid, const SE2& predicted, const SE2& best,
              const RivalZone& zone, double min_score)
      : pyramid_(pyramid), zone_(zone), best_score_(min_score) {
    const double cell = pyramid.resolution_m();
    best_x_ = (best.x - predicted.x) / cell;
    best_y_ = (best.y - predicted.y) / cell;
    zone_cells_ = zone.apart_m / cell;
  }

  // All translations of the window at one heading.
  void search(const Points& points, const SE2& at, double turn_from_best, int radius) {
    cells_.clear();
    same_heading_ = std::abs(wrap_angle(turn_from_best)) < zone_.apart_rad;
    const double cell = pyramid_.resolution_m();
    const double c = std::cos(at.yaw), s = std::sin(at.yaw);
    for (const auto& p : points)
      cells_.push_back({static_cast<int>(std::floor((at.x + c * p.x() - s * p.y()) / cell)),
                        static_cast<int>(std::floor((at.y + s * p.x() + c * p.y()) / cell))});
    radius_ = radius;
    yaw_ = at.yaw;
    const int top = SearchPyramid::kLevels - 1;
    const int stride = SearchPyramid::kStrides[top];
    for (int x = -radius; x <= radius; x += stride)
      for (int y = -radius; y <= radius; y += stride) descend(top, x, y);
  }

  bool found() const { return found_; }
  int x() const { return x_; }
  int y() const { return y_; }
  double yaw() const { return found_yaw_; }
  double score() const { return best_score_; }

 private:
  // The whole block lies in the zone.
  bool covered(int x, int y, int stride) const {
    return same_heading_ && x >= best_x_ - zone_cells_ && x + stride - 1 <= best_x_ + zone_cells_ &&
           y >= best_y_ - zone_cells_ && y + stride - 1 <= best_y_ + zone_cells_;
  }

  double bound(int level, int x, int y) const {
    const PyramidLevel& table = pyramid_.level(level);
    const int shift = table.stride() == 16 ? 4 : (table.stride() == 4 ? 2 : 0);
    int sum = 0;
    for (const CellIndex& cell : cells_)
      sum += table.bound((cell.x + x) >> shift, (cell.y + y) >> shift);
    return sum / (255.0 * static_cast<double>(cells_.size()));
  }

  void descend(int level, int x, int y) {
    const int stride = SearchPyramid::kStrides[static_cast<std::size_t>(level)];
    if (covered(x, y, stride)) return;
    const double score = bound(level, x, y);
    if (score <= best_score_) return;
    if (level == 0) {
      best_score_ = score;
      found_ = true;
      x_ = x, y_ = y;
      found_yaw_ = yaw_;
      return;
    }
    const int step = SearchPyramid::kStrides[static_cast<std::size_t>(level - 1)];
    for (int i = x; i < x + stride && i <= radius_; i += step)
      for (int j = y; j < y + stride && j <= radius_; j += step) descend(level - 1, i, j);
  }

  const SearchPyramid& pyramid_;
  RivalZone zone_;
  double best_score_;
  double best_x_ = 0.0, best_y_ = 0.0, zone_cells_ = 0.0;
  std::vector<CellIndex> cells_;
  bool same_heading_ = false;
  int radius_ = 0;
  double yaw_ = 0.0;
  bool found_ = false;
  int x_ = 0, y_ = 0;
  double found_yaw_ = 0.0;
};

}  // namespace

std::optional<CorrelativeMatch> find_rival(const SearchPyramid& pyramid, const Points& points_base,
                                           const SE2& T_grid_base_predicted,
                                           const SearchWindow& window, const SE2& best,
                                           const RivalZone& zone, double min_score) {
  if (points_base.empty()) return std::nullopt;
  const SE2& predicted = T_grid_base_predicted;
  const double cell = pyramid.resolution_m();
  const int radius = static_cast<int>(std::ceil(window.linear_m / cell - 1e-9));
  const double reach = std::min(window.angular_rad, M_PI);
  const int half = static_cast<int>(std::ceil(reach / angular_step(points_base, cell) - 1e-9));
  RivalSearch search(pyramid, predicted, best, zone, min_score);
  for (int a = -half; a <= half; ++a) {
    const double yaw = predicted.yaw + (half > 0 ? a * reach / half : 0.0);
    search.search(points_base, {predicted.x, predicted.y, yaw}, yaw - best.yaw, radius);
  }
  if (!search.found()) return std::nullopt;
  return CorrelativeMatch{
      {predicted.x + search.x() * cell, predicted.y + search.y() * cell, wrap_angle(search.yaw())},
      search.score()};
}

double match_score(const SearchPyramid& pyramid, const Points& points_base,
                   const SE2& T_grid_base) {
  if (points_base.empty()) return 0.0;
  int sum = 0;
  for (const auto& p : points_base) {
    const Eigen::Vector2d q = T_grid_base * p;
    sum += pyramid.level(0).bound(static_cast<int>(std::floor(q.x() / pyramid.resolution_m())),
                                  static_cast<int>(std::floor(q.y() / pyramid.resolution_m())));
  }
  return sum / (255.0 * static_cast<double>(points_base.size()));
}

}  // namespace fusion_slam
