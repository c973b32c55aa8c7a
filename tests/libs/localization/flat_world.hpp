// A world of walls seen from above: its grid, and what a LiDAR sees in it.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/grid/tiled_grid.hpp"
#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

struct Wall {
  Eigen::Vector2d a, b;  // metres
};

struct FlatWorld {
  double width_m = 9.0, height_m = 6.0;  // all of it floor, from the origin
  std::vector<Wall> walls;
};

inline FlatWorld bare_room() {
  FlatWorld world;
  const Eigen::Vector2d c[] = {{0, 0}, {9, 0}, {9, 6}, {0, 6}};
  for (int i = 0; i < 4; ++i) world.walls.push_back({c[i], c[(i + 1) % 4]});
  return world;
}

// Rooms, a door, furniture; nothing looks like anything else.
inline FlatWorld flat() {
  FlatWorld world = bare_room();
  world.walls.push_back({{4, 0}, {4, 2.2}});
  world.walls.push_back({{4, 3.4}, {4, 6}});
  world.walls.push_back({{5.5, 6}, {5.5, 4.8}});
  world.walls.push_back({{7, 0}, {7, 1.1}});
  world.walls.push_back({{7, 1.1}, {7.7, 1.1}});
  world.walls.push_back({{0, 4.4}, {0.9, 4.4}});
  world.walls.push_back({{0.9, 4.4}, {0.9, 5.2}});
  world.walls.push_back({{1.6, 0}, {1.6, 0.8}});
  world.walls.push_back({{1.6, 0.8}, {2.4, 0.6}});
  return world;
}

// 0.05 m cells; the world's frame is T_map_world's.
inline TiledGrid grid_of(const FlatWorld& world, const SE2& T_map_world = {}) {
  TiledGrid grid(0.05);
  const auto set = [&](const Eigen::Vector2d& p_world, double probability) {
    const Eigen::Vector2d p = T_map_world * p_world;
    grid.set(grid.cell_of(p.x()), grid.cell_of(p.y()), cell_from_probability(probability));
  };
  for (double x = 0.0; x <= world.width_m; x += 0.02)
    for (double y = 0.0; y <= world.height_m; y += 0.02) set({x, y}, 0.1);
  for (const Wall& wall : world.walls) {
    const double length_m = (wall.b - wall.a).norm();
    for (double s = 0.0; s <= length_m; s += 0.01)
      set(wall.a + s / length_m * (wall.b - wall.a), 0.95);
  }
  return grid;
}

// Full circle, up to 8 m, 1 cm of noise; points in base.
inline Points scan_of(const FlatWorld& world, const SE2& T_world_base, unsigned seed,
                      int n_beams = 120) {
  std::mt19937 rng(seed);
  Points points;
  for (int i = 0; i < n_beams; ++i) {
    const double angle = 2.0 * M_PI * i / n_beams;
    const Eigen::Vector2d o(T_world_base.x, T_world_base.y);
    const Eigen::Vector2d d(std::cos(T_world_base.yaw + angle), std::sin(T_world_base.yaw + angle));
    double range = 8.0;
    for (const Wall& wall : world.walls) {
      const Eigen::Vector2d e = wall.b - wall.a, f = wall.a - o;
      const double det = d.y() * e.x() - d.x() * e.y();
      if (std::abs(det) < 1e-12) continue;
      const double t = (f.y() * e.x() - f.x() * e.y()) / det;
      const double s = (f.y() * d.x() - f.x() * d.y()) / det;
      if (t > 0.0 && s >= 0.0 && s <= 1.0) range = std::min(range, t);
    }
    if (range >= 8.0) continue;
    range += 0.01 * (static_cast<double>(rng() % 2001) / 1000.0 - 1.0);
    points.emplace_back(range * std::cos(angle), range * std::sin(angle));
  }
  return points;
}

// A way through both rooms of flat(), 0.25 m a step.
inline std::vector<SE2> way_through() {
  const std::vector<Eigen::Vector2d> corners{
      {2, 1.8}, {2.2, 3.2}, {5, 2.8}, {6.2, 2.2}, {7.8, 3.6}};
  std::vector<SE2> way;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d step = corners[i + 1] - corners[i];
    const int n = static_cast<int>(step.norm() / 0.25);
    for (int k = 0; k < n; ++k) {
      const Eigen::Vector2d p = corners[i] + step * k / n;
      way.push_back({p.x(), p.y(), std::atan2(step.y(), step.x())});
    }
  }
  return way;
}

}  // namespace fusion_slam
