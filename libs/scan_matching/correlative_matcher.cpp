#include "libs/scan_matching/correlative_matcher.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

// A block of translations [x, x + stride) x [y, y + stride) cells at one angle.
struct Candidate {
  int angle;
  int x;
  int y;
  double bound;
};

class Search {
 public:
  Search(const SearchPyramid& pyramid, const Points& points, const SE2& predicted,
         const SearchWindow& window, double min_score)
      : pyramid_(pyramid), window_(window), best_{0, 0, 0, min_score} {
    radius_ = static_cast<int>(std::ceil(window.linear_m / pyramid.resolution_m() - 1e-9));
    const double step = angular_step(points, pyramid.resolution_m());
    const double reach = std::min(window.angular_rad, M_PI);
    half_angles_ = static_cast<int>(std::ceil(reach / step - 1e-9));
    angle_step_ = half_angles_ > 0 ? reach / half_angles_ : 0.0;
    n_points_ = static_cast<int>(points.size());
    for (int a = -half_angles_; a <= half_angles_; ++a) place(points, predicted, a * angle_step_);
  }

  std::optional<Candidate> run() {
    int top = 0;
    while (top + 1 < SearchPyramid::kLevels &&
           SearchPyramid::kStrides[static_cast<std::size_t>(top)] < radius_)
      ++top;
    const int stride = SearchPyramid::kStrides[static_cast<std::size_t>(top)];
    std::vector<Candidate> candidates;
    for (int a = 0; a <= 2 * half_angles_; ++a)
      for (int x = -radius_; x <= radius_; x += stride)
        for (int y = -radius_; y <= radius_; y += stride)
          candidates.push_back({a, x, y, bound(top, a, x, y)});
    descend(top, candidates);
    if (!found_) return std::nullopt;
    return best_;
  }

  double angle_of(const Candidate& c) const { return (c.angle - half_angles_) * angle_step_; }

 private:
  void place(const Points& points, const SE2& predicted, double turn) {
    const SE2 T{predicted.x, predicted.y, predicted.yaw + turn};
    const double c = std::cos(T.yaw) / pyramid_.resolution_m();
    const double s = std::sin(T.yaw) / pyramid_.resolution_m();
    const double x = T.x / pyramid_.resolution_m();
    const double y = T.y / pyramid_.resolution_m();
    for (const auto& p : points)
      cells_.push_back({static_cast<int>(std::floor(x + c * p.x() - s * p.y())),
                        static_cast<int>(std::floor(y + s * p.x() + c * p.y()))});
  }

  // Least penalty of the block: that of its translation nearest to the prediction.
  double penalty(int level, const Candidate& c) const {
    if (window_.edge_penalty <= 0.0) return 0.0;
    const int last = SearchPyramid::kStrides[static_cast<std::size_t>(level)] - 1;
    const auto nearest = [&](int low) { return std::clamp(0, low, low + last); };
    const double reach = std::max(1, radius_);
    const double dx = nearest(c.x) / reach;
    const double dy = nearest(c.y) / reach;
    const double da =
        half_angles_ > 0 ? static_cast<double>(c.angle - half_angles_) / half_angles_ : 0.0;
    return window_.edge_penalty * (dx * dx + dy * dy + da * da);
  }

  double bound(int level, int angle, int x, int y) const {
    const PyramidLevel& table = pyramid_.level(level);
    const CellIndex* cell = cells_.data() + static_cast<std::ptrdiff_t>(angle) * n_points_;
    int sum = 0;
    if (table.stride() == 1) {
      for (int i = 0; i < n_points_; ++i) sum += table.bound(cell[i].x + x, cell[i].y + y);
    } else {
      const int shift = table.stride() == 4 ? 2 : 4;
      for (int i = 0; i < n_points_; ++i)  // >> is floor division for signed numbers too
        sum += table.bound((cell[i].x + x) >> shift, (cell[i].y + y) >> shift);
    }
    return sum / (255.0 * n_points_) - penalty(level, {angle, x, y, 0.0});
  }

  void descend(int level, std::vector<Candidate>& candidates) {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.bound > b.bound; });
    for (const Candidate& c : candidates) {
      if (c.bound <= best_.bound) return;
      if (level == 0) {
        best_ = c;
        found_ = true;
        return;
      }
      const int stride = SearchPyramid::kStrides[static_cast<std::size_t>(level)];
      const int child = SearchPyramid::kStrides[static_cast<std::size_t>(level - 1)];
      std::vector<Candidate> children;
      for (int x = c.x; x < c.x + stride && x <= radius_; x += child)
        for (int y = c.y; y < c.y + stride && y <= radius_; y += child)
          children.push_back({c.angle, x, y, bound(level - 1, c.angle, x, y)});
      descend(level - 1, children);
    }
  }

  const SearchPyramid& pyramid_;
  const SearchWindow& window_;
  int radius_ = 0;
  int half_angles_ = 0;
  double angle_step_ = 0.0;
  int n_points_ = 0;
  std::vector<CellIndex> cells_;  // angle by angle, point by point
  Candidate best_;
  bool found_ = false;
};

}  // namespace

double angular_step(const Points& points_base, double resolution_m) {
  if (points_base.empty()) return M_PI;
  std::vector<double> distances;
  for (const auto& p : points_base) distances.push_back(p.norm());
  const auto most = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() * 4 / 5);
  std::nth_element(distances.begin(), most, distances.end());
  return resolution_m / std::max(*most, 10.0 * resolution_m);
}

SearchWindow window_from_covariance(const Eigen::Matrix3d& covariance_grid, double sigmas,
                                    const SearchWindow& least, const SearchWindow& most) {
  // The window is as wide in y as in x: the longer axis of the ellipse counts.
  const double xx = covariance_grid(0, 0), yy = covariance_grid(1, 1), xy = covariance_grid(0, 1);
  const double longest = 0.5 * (xx + yy) + std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  const auto within = [&](double variance, double low, double high) {
    // A variance that is no number or negative knows nothing.
    const double reach = variance >= 0.0 ? sigmas * std::sqrt(variance) : high;
    return std::clamp(reach, low, std::max(low, high));
  };
  SearchWindow window;
  window.linear_m = within(longest, least.linear_m, most.linear_m);
  window.angular_rad = within(covariance_grid(2, 2), least.angular_rad, most.angular_rad);
  return window;
}

Eigen::Matrix3d grid_axes(const Eigen::Matrix3d& covariance_base, double yaw_rad) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(yaw_rad).toRotationMatrix();
  return turn * covariance_base * turn.transpose();
}

std::optional<CorrelativeMatch> match_correlative(const SearchPyramid& pyramid,
                                                  const Points& points_base,
                                                  const SE2& T_grid_base_predicted,
                                                  const SearchWindow& window, double min_score) {
  if (points_base.empty()) return std::nullopt;
  Search search(pyramid, points_base, T_grid_base_predicted, window, min_score);
  const auto best = search.run();
  if (!best) return std::nullopt;
  const double cell = pyramid.resolution_m();
  const SE2& T = T_grid_base_predicted;
  return CorrelativeMatch{
      {T.x + best->x * cell, T.y + best->y * cell, wrap_angle(T.yaw + search.angle_of(*best))},
      best->bound};
}

}  // namespace fusion_slam
