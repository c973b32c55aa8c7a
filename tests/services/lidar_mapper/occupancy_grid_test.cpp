#include "services/lidar_mapper/occupancy_grid.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

double odds(double p) { return p / (1.0 - p); }
double probability(double o) { return o / (1.0 + o); }

TEST(OccupancyGrid, IsEquation7CellByCellWithClamps) {
  const LidarMapperConfig config;
  OccupancyGrid grid(0.1, config);
  double hit = 1.0, miss = 1.0;  // odds
  for (int scan = 0; scan < 30; ++scan) {
    grid.insert({0.05, 0.05}, {{1.05, 0.05}, {1.06, 0.06}});  // two beams, one cell: one hit
    hit = std::min(hit * odds(config.hit_probability), odds(config.max_probability));
    miss = std::max(miss * odds(config.miss_probability), odds(config.min_probability));
    EXPECT_NEAR(probability_from_cell(grid.raster().at(10, 0)), probability(hit), 0.004);
    for (int x = 0; x < 10; ++x)
      EXPECT_NEAR(probability_from_cell(grid.raster().at(x, 0)), probability(miss), 0.004);
    EXPECT_EQ(grid.raster().at(11, 0), kUnknownCell);
    EXPECT_EQ(grid.raster().at(5, 1), kUnknownCell);
  }
}

TEST(OccupancyGrid, RaysFillWhatTheyCrossAndHitsBeatMisses) {
  const LidarMapperConfig config;
  OccupancyGrid grid(0.05, config);
  Points ring;
  for (int i = 0; i < 2000; ++i)
    ring.emplace_back(3.0 * std::cos(i * M_PI / 1000), 3.0 * std::sin(i * M_PI / 1000));
  grid.insert({0, 0}, ring);
  const std::uint8_t even = cell_from_probability(0.5);
  int unknown = 0;  // an integer line may step past a cell far out
  for (int y = -40; y <= 40; ++y)
    for (int x = -40; x <= 40; ++x) {
      unknown += grid.raster().at(x, y) == kUnknownCell ? 1 : 0;
      ASSERT_LT(grid.raster().at(x, y), even);
    }
  EXPECT_LT(unknown, 65);
  for (const auto& p : ring) {
    const CellIndex c = grid.raster().cell_of(p.x(), p.y());
    ASSERT_GT(grid.raster().at(c.x, c.y), even);
  }
}

TEST(OccupancyGrid, ChangedTilesAreExactlyThoseWhoseCellsChanged) {
  const LidarMapperConfig config;
  OccupancyGrid grid(0.05, config);
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> u(-9.0, 9.0);
  std::map<TileIndex, TileCells> before;
  for (int scan = 0; scan < 20; ++scan) {
    grid.insert({u(rng), u(rng)}, {{u(rng), u(rng)}, {u(rng), u(rng)}});
    for (int ty = -4; ty < 4; ++ty)
      for (int tx = -4; tx < 4; ++tx) {
        TileCells now;
        for (int y = 0; y < kTileCells; ++y)
          for (int x = 0; x < kTileCells; ++x)
            now[static_cast<std::size_t>(y * kTileCells + x)] =
                grid.raster().at(tx * kTileCells + x, ty * kTileCells + y);
        auto [it, made] = before.try_emplace({tx, ty});
        if (made) it->second.fill(kUnknownCell);
        const bool changed = grid.changed_tiles().count({tx, ty}) != 0;
        if (now != it->second) {
          ASSERT_TRUE(changed);
          ASSERT_EQ(grid.tile({tx, ty}), now);
        }
        it->second = now;
      }
    grid.forget_changes();
  }
}

}  // namespace
}  // namespace fusion_slam
