// What the fused map costs as it grows: area_bench SIDE_m. Rooms of 6.4 m with boxes in them cover
// SIDE x SIDE metres, seen by both sensors; then one more LiDAR submap and one more camera tile
// come, and one submap is moved by the graph. CPU time.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>

#include "services/fuser/fuser.hpp"

namespace fusion_slam {
namespace {

constexpr double kResolution_m = 0.05;
constexpr int kTile = 64;        // cells: 3.2 m
constexpr int kSubmapTiles = 4;  // a submap is 12.8 m wide

double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// One tile of rooms: walls at every second tile's edge, and boxes where chance puts them.
TileCells rooms(int x, int y, unsigned seed) {
  std::mt19937 random(seed + 1000U * static_cast<unsigned>(x) + static_cast<unsigned>(y));
  TileCells cells;
  cells.fill(cell_from_probability(0.1));
  const std::uint8_t wall = cell_from_probability(0.9);
  for (int i = 0; i < kTile; ++i) {
    if (x % 2 == 0) cells[static_cast<std::size_t>(i * kTile)] = wall;
    if (y % 2 == 0) cells[static_cast<std::size_t>(i)] = wall;
  }
  for (int box = 0; box < 3; ++box) {
    const auto at = [&] { return 4 + static_cast<int>(random() % 48U); };
    const int bx = at();
    const int by = at();
    for (int v = by; v < by + 8; ++v)
      for (int u = bx; u < bx + 8; ++u) cells[static_cast<std::size_t>(v * kTile + u)] = wall;
  }
  return cells;
}

Tile tile(std::int64_t submap, int x, int y, const TileCells& cells, std::int64_t utime_us) {
  return encode_grid_tile({submap, x, y, 0}, cells, kResolution_m, 1, utime_us);
}

SE3 shifted(double x_m, double y_m) {
  SE3 T = SE3::Identity();
  T.translation() << x_m, y_m, 0.0;
  return T;
}

void run(double side_m) {
  Fuser fuser(kResolution_m, FuserConfig{});
  const int n = std::max(1, static_cast<int>(std::ceil(side_m / (kTile * kResolution_m))));
  std::int64_t now_us = 1;
  const auto submap_of = [&](int x, int y) {
    return 1 + x / kSubmapTiles + 10'000LL * (y / kSubmapTiles);
  };
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      fuser.add_submap_tile(tile(submap_of(x, y), x, y, rooms(x, y, 1), now_us));
      fuser.set_anchor(submap_of(x, y), SE3::Identity(), now_us);
      fuser.add_visual_tile(tile(0, x, y, rooms(x, y, 2), now_us));
    }
  double before_ms = cpu_ms();
  const std::size_t all = fuser.update(true).fused.size();
  const double whole_ms = cpu_ms() - before_ms;

  constexpr int kTimes = 20;
  const auto mean_of = [&](const auto& change) {
    before_ms = cpu_ms();
    for (int k = 0; k < kTimes; ++k) {
      now_us += 2'000'000;
      change(k);
      fuser.update(false);
    }
    return (cpu_ms() - before_ms) / kTimes;
  };
  const int at = n / 2;
  const double camera_ms = mean_of([&](int k) {
    fuser.add_visual_tile(tile(0, at, at, rooms(at, at, 3U + static_cast<unsigned>(k)), now_us));
  });
  const double lidar_ms = mean_of([&](int k) {
    fuser.add_submap_tile(
        tile(submap_of(at, at), at, at, rooms(at, at, 100U + static_cast<unsigned>(k)), now_us));
  });
  const double moved_ms = mean_of(
      [&](int k) { fuser.set_anchor(submap_of(at, at), shifted(0.05 * (k % 5), 0.0), now_us); });
  const double area_m2 = std::pow(n * kTile * kResolution_m, 2);
  std::printf(
      "%.0f m2, %zu tiles: all at once %.1f ms, one camera tile %.2f ms, one LiDAR tile %.2f ms, "
      "one submap moved %.2f ms\n",
      area_m2, all, whole_ms, camera_ms, lidar_ms, moved_ms);
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  if (argc < 2 || std::atof(argv[1]) <= 0.0) {
    std::fprintf(stderr,
                 "usage: area_bench SIDE_m ...: the fused map's cost over SIDE x SIDE metres\n");
    return 2;
  }
  for (int i = 1; i < argc; ++i) fusion_slam::run(std::atof(argv[i]));
  return 0;
}
