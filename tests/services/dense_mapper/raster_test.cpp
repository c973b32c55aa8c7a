#include "services/dense_mapper/raster.hpp"

#include <gtest/gtest.h>

#include "libs/grid/cell_state.hpp"
#include "libs/octree/octomap_tile.hpp"

namespace fusion_slam {
namespace {

const std::int8_t kFree = -64;  // log-odds -2
const std::int8_t kHit = 64;
const std::int8_t kNever = kUnknownVoxel;

TEST(Raster, OneOccupiedVoxelMakesTheCellOccupied) {
  EXPECT_EQ(state_of_cell(raster_cell({kFree, kFree, kHit, kNever})), CellState::kOccupied);
}

TEST(Raster, FreeNeedsMostOfTheColumn) {
  EXPECT_EQ(raster_cell({kNever, kNever}), kUnknownCell);
  EXPECT_EQ(state_of_cell(raster_cell({kFree, kFree, kFree, kFree})), CellState::kUnoccupied);
  EXPECT_EQ(state_of_cell(raster_cell({kFree, kFree, kFree, kNever})), CellState::kUnoccupied);
  const std::uint8_t half = raster_cell({kFree, kNever, kFree, kNever});
  EXPECT_EQ(state_of_cell(half), CellState::kUnknown);  // no verdict
  EXPECT_NE(half, kUnknownCell);                        // but seen
}

TEST(Raster, ProbabilityIsThatOfTheLogOdds) {
  EXPECT_EQ(raster_cell({kFree, 32}), cell_from_probability(0.7310585786));
  EXPECT_EQ(raster_cell({kFree, kNever}), cell_from_probability(0.2689414214));
}

TEST(Raster, TileTakesEachColumn) {
  std::vector<std::int8_t> band(64 * 64 * 2, kNever);
  band[5 * 64 + 7] = kFree;
  band[64 * 64 + 5 * 64 + 7] = kHit;
  const TileCells cells = raster_tile(band);
  EXPECT_EQ(cells[5 * 64 + 7], raster_cell({kFree, kHit}));
  EXPECT_EQ(cells[5 * 64 + 8], kUnknownCell);
}

}  // namespace
}  // namespace fusion_slam
