#include "services/dense_mapper/raster.hpp"

#include <random>

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
  std::vector<std::int8_t> column(11, kFree);
  for (int unseen = 1; unseen <= 11; ++unseen) {
    column[static_cast<std::size_t>(unseen - 1)] = kNever;
    const std::uint8_t cell = raster_cell(column);
    EXPECT_EQ(state_of_cell(cell), unseen <= 3 ? CellState::kUnoccupied : CellState::kUnknown)
        << unseen;
    EXPECT_EQ(cell == kUnknownCell, unseen == 11) << unseen;  // without a verdict, but seen
    EXPECT_LE(probability_from_cell(cell), 0.5);
  }
}

TEST(Raster, ProbabilityIsThatOfTheLogOdds) {
  EXPECT_EQ(raster_cell({kFree, 32}), cell_from_probability(0.7310585786));
  EXPECT_EQ(raster_cell({kFree, kNever}), cell_from_probability(0.3775406688));  // (-2 + 1) / 2
}

TEST(Raster, BandIsTheVoxelsWithTheirCentresInIt) {
  EXPECT_EQ(band_between(0.05, 0.60, 0.05).from, 1);
  EXPECT_EQ(band_between(0.05, 0.60, 0.05).to, 12);
  EXPECT_EQ(band_between(0.07, 0.60, 0.05).from, 1);
  EXPECT_EQ(band_between(0.08, 0.60, 0.05).from, 2);
  EXPECT_EQ(band_between(-0.1, -0.1, 0.05).to - band_between(-0.1, -0.1, 0.05).from, 1);
  EXPECT_EQ(band_between(0.15, 1.80, 0.10).to, 18);
}

VoxelCells all_free() {
  VoxelCells cells;
  cells.fill(kFree);
  return cells;
}

TEST(Raster, ColumnsAreRasterCells) {
  std::mt19937 random(4);
  VoxelCells low, high;
  for (VoxelCells* cells : {&low, &high})
    for (auto& cell : *cells)
      cell = random() % 3 == 0 ? kNever
                               : static_cast<std::int8_t>(static_cast<int>(random() % 80) - 70);
  ColumnRaster raster;
  raster.add(low, 29, 32, 0);
  raster.add(high, 0, 5, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      std::vector<std::int8_t> column;
      for (int z = 29; z < 32; ++z) column.push_back(low[voxel_index(x, y, z)]);
      for (int z = 0; z < 5; ++z) column.push_back(high[voxel_index(x, y, z)]);
      const auto i = static_cast<std::size_t>(y * 32 + x);
      EXPECT_EQ(raster.cell(i, 8), raster_cell(column));
      for (std::size_t z = 0; z < column.size(); ++z) {
        EXPECT_EQ(raster.known(i) >> z & 1U, column[z] == kNever ? 0U : 1U);
        EXPECT_EQ(raster.occupied(i) >> z & 1U, column[z] > 0 ? 1U : 0U);
      }
    }
}

// A seat, voxel 8 of a band of 11, of which only the rim was seen, across the edge of two columns.
ColumnRasters seat(bool far_rim, bool above_seen, bool solid) {
  std::vector<VoxelCells> cubes(2, all_free());
  for (int x = 28; x <= 36; ++x)
    for (int y = 10; y <= 18; ++y) {
      const bool rim = x == 28 || y == 10 || (far_rim && (x == 36 || y == 18));
      VoxelCells& cube = cubes[static_cast<std::size_t>(x >> 5)];
      cube[voxel_index(x & 31, y, 7)] = rim ? kHit : kNever;
      if (solid)
        for (int z = 0; z < 7; ++z) cube[voxel_index(x & 31, y, z)] = rim ? kHit : kNever;
      if (!above_seen)
        for (int z = 8; z < 11; ++z) cube[voxel_index(x & 31, y, z)] = rim ? kFree : kNever;
    }
  ColumnRasters rasters;
  rasters[{0, 0}].add(cubes[0], 0, 11, 0);
  rasters[{1, 0}].add(cubes[1], 0, 11, 0);
  return rasters;
}
CellState inside(const ColumnRasters& rasters, int x, int y) {
  const ColumnCells cells = raster_column(rasters, {x >> 5, 0}, 11, 0.05);
  return state_of_cell(cells[static_cast<std::size_t>(y * 32 + (x & 31))]);
}

TEST(Raster, WithinARimIsASeat) {
  for (const int x : {30, 33})
    for (const int y : {12, 16}) {
      EXPECT_EQ(inside(seat(true, false, false), x, y), CellState::kOccupied) << x << " " << y;
      EXPECT_EQ(inside(seat(false, true, false), x, y), CellState::kOccupied) << x << " " << y;
      // A shadow that nobody looked over, and the inside of a solid, are no seats.
      EXPECT_NE(inside(seat(false, false, false), x, y), CellState::kOccupied) << x << " " << y;
      EXPECT_NE(inside(seat(true, false, true), x, y), CellState::kOccupied) << x << " " << y;
    }
  EXPECT_EQ(inside(seat(true, true, false), 20, 14), CellState::kUnoccupied);
}

// Bed: voxels 0-6 unseen within an outline that is closed or not, free space above.
TEST(Raster, UnderATopWithAnOutlineIsABed) {
  for (const bool closed : {true, false}) {
    VoxelCells cube = all_free();
    for (int x = 5; x <= 25; ++x)
      for (int y = 4; y <= 28; ++y) {
        const bool outline = x == 5 || x == 25 || y == 4 || (closed && y == 28);
        for (int z = 0; z < 7; ++z) cube[voxel_index(x, y, z)] = outline ? kHit : kNever;
      }
    ColumnRasters rasters;
    rasters[{0, 0}].add(cube, 0, 11, 0);
    EXPECT_EQ(inside(rasters, 15, 16) == CellState::kOccupied, closed);
  }
}

}  // namespace
}  // namespace fusion_slam
