#include "libs/maps/map_raster.hpp"

#include <gtest/gtest.h>

#include "tests/libs/maps/test_files.hpp"

namespace fusion_slam {
namespace {

TEST(MapRaster, HoldsEveryKnownCellAndNoMore) {
  const MapRaster raster = small_raster();
  EXPECT_EQ(raster.width, 3);
  EXPECT_EQ(raster.height, 2);
  EXPECT_DOUBLE_EQ(raster.origin_x_m, -0.1);
  EXPECT_DOUBLE_EQ(raster.origin_y_m, 0.15);
  EXPECT_EQ(state_of_cell(raster.probability[raster.index(0, 0)]), CellState::kOccupied);
  EXPECT_EQ(state_of_cell(raster.probability[raster.index(2, 0)]), CellState::kUnoccupied);
  EXPECT_EQ(state_of_cell(raster.probability[raster.index(2, 1)]), CellState::kUnknown);
  EXPECT_EQ(raster.provenance[raster.index(1, 1)], 2);
}

TEST(MapRaster, ThresholdsAreRos) {
  EXPECT_EQ(state_of_cell(kUnknownCell), CellState::kUnknown);
  for (int cell = 1; cell <= 255; ++cell) {
    const double p = probability_from_cell(static_cast<std::uint8_t>(cell));
    const CellState expected = p > 0.65   ? CellState::kOccupied
                               : p < 0.25 ? CellState::kUnoccupied
                                          : CellState::kUnknown;
    EXPECT_EQ(state_of_cell(static_cast<std::uint8_t>(cell)), expected) << cell;
  }
}

TEST(MapRaster, NothingKnownAndAbsurdSizesHaveAReason) {
  std::string why;
  EXPECT_FALSE(make_raster({}, 0.05, &why));
  EXPECT_EQ(why, "no cell of the map is known");
  auto tiles = small_map();
  tiles[{30'000'000, -30'000'000}] = tiles[{0, 0}];
  EXPECT_FALSE(make_raster(tiles, 0.05, &why));
  EXPECT_NE(why.find("damaged index"), std::string::npos);
}

}  // namespace
}  // namespace fusion_slam
