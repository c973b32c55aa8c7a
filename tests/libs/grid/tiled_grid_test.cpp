#include "libs/grid/tiled_grid.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(TiledGrid, NegativeCellsLieInNegativeTiles) {
  TiledGrid grid(0.05);
  grid.set(-1, -64, 9);
  grid.set(64, 0, 7);
  EXPECT_EQ(grid.at(-1, -64), 9);
  EXPECT_EQ(grid.at(64, 0), 7);
  EXPECT_EQ(grid.at(-65, -64), kUnknownCell);
  ASSERT_EQ(grid.tiles().size(), 2U);
  EXPECT_EQ(grid.tiles().begin()->first, TileIndex(-1, -1));
  EXPECT_EQ(grid.tiles().rbegin()->first, TileIndex(1, 0));
  EXPECT_EQ(grid.cell_of(-0.01), -1);
  EXPECT_EQ(grid.cell_of(0.051), 1);
}

TEST(TiledGrid, EachByteIsItsOwnProbability) {
  EXPECT_DOUBLE_EQ(probability_from_cell(kUnknownCell), 0.5);
  for (int cell = 1; cell < 256; ++cell)
    EXPECT_EQ(cell_from_probability(probability_from_cell(static_cast<std::uint8_t>(cell))), cell);
  EXPECT_EQ(cell_from_probability(-1.0), 1);
  EXPECT_EQ(cell_from_probability(2.0), 255);
}

TEST(TiledGrid, TileSurvivesTheWire) {
  TileCells cells;
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<std::uint8_t>(i * 7);
  const Tile tile = encode_grid_tile({3, -1, 2, 0}, cells, 0.05, 8, 1000);
  const auto back = decode_grid_tile(tile);
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, cells);
  Tile damaged = tile;
  damaged.data.resize(damaged.data.size() / 2);
  EXPECT_FALSE(decode_grid_tile(damaged));
}

}  // namespace
}  // namespace fusion_slam
