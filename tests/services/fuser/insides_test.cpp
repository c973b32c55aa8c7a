#include "services/fuser/insides.hpp"

#include <gtest/gtest.h>

#include "libs/grid/cell_state.hpp"
#include "services/fuser/fuser.hpp"

namespace fusion_slam {
namespace {

constexpr double kResolution = 0.05;
const std::uint8_t kNoVerdict = cell_from_probability(0.5);

// A sofa of 30 x 20 cells across the edge of two tiles: its outline is occupied, around it is free
// space. gap: one cell of the outline was seen to be free.
struct Sofa {
  std::map<TileIndex, FusedCells> fused;
  std::map<TileIndex, TileCells> camera;

  explicit Sofa(bool gap) {
    for (const TileIndex& index : {TileIndex{0, 0}, TileIndex{1, 0}}) {
      fused[index].probability.fill(cell_from_probability(0.1));
      camera[index].fill(cell_from_probability(0.1));
    }
    for (int y = 10; y < 30; ++y)
      for (int x = 50; x < 80; ++x) {
        const bool outline = x == 50 || x == 79 || y == 10 || y == 29;
        if (gap && x == 60 && y == 10) continue;
        fused[{x >> 6, 0}].probability[at(x, y)] =
            outline ? cell_from_probability(0.9) : kNoVerdict;
        camera[{x >> 6, 0}][at(x, y)] = kNoVerdict;
      }
  }
  static std::size_t at(int x, int y) {
    return static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x & 63);
  }
  CellState filled(int x, int y) const {
    const TileIndex index{x >> 6, 0};
    return state_of_cell(
        fill_insides(fused, index, camera.at(index), kResolution).probability[at(x, y)]);
  }
};

TEST(Insides, OfASofaAreOccupiedOnBothSidesOfATilesEdge) {
  const Sofa sofa(false);
  for (const int x : {51, 63, 64, 78})
    for (const int y : {11, 28}) EXPECT_EQ(sofa.filled(x, y), CellState::kOccupied) << x << y;
  EXPECT_EQ(sofa.filled(49, 20), CellState::kUnoccupied);
  EXPECT_EQ(sofa.filled(85, 5), CellState::kUnoccupied);
}

TEST(Insides, WhereTheOutlineIsOpenNothingIsClaimed) {
  const Sofa sofa(true);
  EXPECT_EQ(sofa.filled(60, 20), CellState::kUnknown);
  EXPECT_EQ(sofa.filled(61, 20), CellState::kOccupied);
}

TEST(Insides, WhatNobodyLookedOverStaysUnknown) {
  Sofa pillar(false);
  for (auto& [index, cells] : pillar.camera) cells.fill(kUnknownCell);
  EXPECT_EQ(pillar.filled(60, 20), CellState::kUnknown);
}

TEST(Insides, TooWideIsARoom) {
  std::map<TileIndex, FusedCells> fused;
  TileCells camera;
  camera.fill(kNoVerdict);
  FusedCells& cells = fused[{0, 0}];
  cells.probability.fill(kNoVerdict);
  for (int i = 0; i < kTileCells; ++i)
    for (const std::size_t cell :
         {Sofa::at(i, 0), Sofa::at(i, 63), Sofa::at(0, i), Sofa::at(63, i)})
      cells.probability[cell] = cell_from_probability(0.9);
  const FusedCells filled = fill_insides(fused, {0, 0}, camera, 0.05);
  EXPECT_EQ(state_of_cell(filled.probability[Sofa::at(1, 1)]), CellState::kUnknown);     // 3.1 m
  EXPECT_EQ(state_of_cell(filled.probability[Sofa::at(31, 31)]), CellState::kOccupied);  // 1.6 m
}

// In the fuser the outline's last cell may come with another tile than the inside.
TEST(Insides, FollowTheTileBeside) {
  const Sofa sofa(false);
  Fuser fuser(kResolution, FuserConfig{});
  const auto say = [&](const TileIndex& index) {
    TileCells cells = sofa.fused.at(index).probability;
    EXPECT_TRUE(fuser.add_visual_tile(
        encode_grid_tile({0, index.first, index.second, 0}, cells, kResolution, 1, 5)));
    return fuser.update(false).fused;
  };
  const auto inside = [](const Tile& tile) {
    return state_of_cell(decode_fused_tile(tile)->probability[Sofa::at(60, 20)]);
  };
  const auto first = say({0, 0});
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(inside(first[0]), CellState::kUnknown);
  const auto second = say({1, 0});
  ASSERT_EQ(second.size(), 2U);
  EXPECT_EQ(inside(second[0]), CellState::kOccupied);
}

}  // namespace
}  // namespace fusion_slam
