// A room drawn into a raster, and a scan of its walls, for matching tests.
#pragma once

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/scan_matching/surface_normals.hpp"
#include "libs/scan_matching/surface_refiner.hpp"

namespace fusion_slam {

inline void draw_line(Raster& raster, Eigen::Vector2d a, Eigen::Vector2d b, std::uint8_t value) {
  const int steps = static_cast<int>((b - a).norm() / (0.25 * raster.resolution_m()));
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d p = a + (b - a) * i / steps;
    const CellIndex c = raster.cell_of(p.x(), p.y());
    raster.include(c, c);
    raster.cell(c.x, c.y) = value;
  }
}

// 6 m x 4 m with a cupboard in one corner: no symmetry.
inline std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> room_walls() {
  return {{{-3, -2}, {3, -2}}, {{3, -2}, {3, 2}},      {{3, 2}, {-3, 2}},
          {{-3, 2}, {-3, -2}}, {{1.5, 2}, {1.5, 1.2}}, {{1.5, 1.2}, {3, 1.2}}};
}

inline Raster room_raster(double resolution_m = 0.05) {
  Raster raster(resolution_m, kUnknownCell);
  for (const auto& [a, b] : room_walls()) draw_line(raster, a, b, cell_from_probability(0.9));
  return raster;
}

// Points of the walls as seen in base at T_grid_base.
inline Points room_points(const SE2& T_grid_base, int n, double noise_m, std::uint32_t seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise(0.0, noise_m > 0.0 ? noise_m : 1.0);
  std::uniform_real_distribution<double> along(0.0, 1.0);
  const auto walls = room_walls();
  const SE2 T_base_grid = T_grid_base.inverse();
  Points points;
  for (int i = 0; i < n; ++i) {
    const auto& [a, b] = walls[static_cast<std::size_t>(i) % walls.size()];
    Eigen::Vector2d p = a + (b - a) * along(rng);
    if (noise_m > 0.0) p += Eigen::Vector2d(noise(rng), noise(rng));
    points.push_back(T_base_grid * p);
  }
  return points;
}

// A sweep in the room, in the order of the beams, with noise along them; the base moves by `twist`
// during it, and points are in base as it stood at their beam.
inline SweepPoints room_sweep(const SE2& T_room_base, const Twist& twist, double sweep_s,
                              double noise_m, std::uint32_t seed, int n = 360) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  SweepPoints sweep;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * i / n, time_s = sweep_s * i / n;
    const SE2 T = T_room_base * twist.motion(time_s);
    const Eigen::Vector2d o(T.x, T.y), d(std::cos(T.yaw + angle), std::sin(T.yaw + angle));
    double nearest = 1e9;
    for (const auto& [a, b] : room_walls()) {
      const Eigen::Vector2d e = a - b, f = a - o;  // o + s d = a + t (b - a)
      const double det = d.x() * e.y() - d.y() * e.x();
      if (std::abs(det) < 1e-12) continue;
      const double s = (f.x() * e.y() - f.y() * e.x()) / det;
      const double t = (d.x() * f.y() - d.y() * f.x()) / det;
      if (t >= 0.0 && t <= 1.0 && s > 0.0) nearest = std::min(nearest, s);
    }
    const double r = nearest + noise_m * normal(rng);
    sweep.points.emplace_back(r * std::cos(angle), r * std::sin(angle));
    if (sweep_s > 0.0) sweep.time_s.push_back(time_s);
  }
  sweep.normals = surface_normals(sweep.points, {0, 0});
  return sweep;
}

}  // namespace fusion_slam
