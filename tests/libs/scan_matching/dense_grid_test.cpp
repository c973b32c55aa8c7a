#include "libs/scan_matching/dense_grid.hpp"

#include <map>
#include <random>

#include <gtest/gtest.h>

#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {
namespace {

TEST(DenseGrid, KeepsItsCellsWhileItGrows) {
  std::mt19937 rng(1);
  std::uniform_int_distribution<int> u(-300, 300);
  DenseGrid<int> grid(0.05, -1);
  std::map<std::pair<int, int>, int> expected;
  for (int i = 1; i <= 500; ++i) {
    const CellIndex c{u(rng), u(rng)};
    grid.include(c, c);
    grid.cell(c.x, c.y) = i;
    expected[{c.x, c.y}] = i;
  }
  for (const auto& [c, value] : expected) EXPECT_EQ(grid.at(c.first, c.second), value);
  EXPECT_EQ(grid.at(100000, 0), -1);
  EXPECT_EQ(grid.min_x() % kTileCells, 0);
  EXPECT_EQ(grid.width() % kTileCells, 0);
}

TEST(DenseGrid, CellsAreFloorOfCoordinates) {
  const DenseGrid<int> grid(0.05);
  EXPECT_EQ(grid.cell_of(0.01, -0.01).x, 0);
  EXPECT_EQ(grid.cell_of(0.01, -0.01).y, -1);
  EXPECT_EQ(tile_floor(-1), -64);
  EXPECT_EQ(tile_floor(-64), -64);
  EXPECT_EQ(tile_floor(63), 0);
}

TEST(Raster, IsTheTilesInOnePiece) {
  std::mt19937 rng(2);
  std::uniform_int_distribution<int> u(-150, 150);
  TiledGrid tiles(0.1);
  for (int i = 0; i < 300; ++i) tiles.set(u(rng), u(rng), static_cast<std::uint8_t>(1 + i % 255));
  const Raster raster = raster_from_tiles(tiles);
  for (int y = -200; y < 200; ++y)
    for (int x = -200; x < 200; ++x) ASSERT_EQ(raster.at(x, y), tiles.at(x, y));
}

}  // namespace
}  // namespace fusion_slam
