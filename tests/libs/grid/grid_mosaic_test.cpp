#include "libs/grid/grid_mosaic.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

constexpr double kResolution = 0.05;

TileCells random_cells(std::mt19937* random) {
  TileCells cells;
  for (auto& cell : cells) cell = static_cast<std::uint8_t>((*random)() % 3 == 0 ? (*random)() : 0);
  return cells;
}

TileCells all(std::uint8_t value) {
  TileCells cells;
  cells.fill(value);
  return cells;
}

// Equation 7, folded over the submaps one after the other, for one map cell.
std::uint8_t by_equation_7(const std::vector<double>& probabilities) {
  double p = 0.5;
  for (const double s : probabilities)
    p = std::clamp(s * p / (s * p + (1 - s) * (1 - p)), 0.02, 0.98);
  return cell_from_probability(p);
}

TEST(GridMosaic, OneSubmapAtTheOriginIsCopied) {
  GridMosaic mosaic(kResolution);
  std::mt19937 random(1);
  TileCells cells = random_cells(&random);
  for (auto& cell : cells)
    if (cell != 0 && (cell < 10 || cell > 245)) cell = 128;  // within the clamping bounds
  mosaic.set_tile(3, {-1, 2}, cells, kResolution);
  EXPECT_TRUE(mosaic.recompose(true).empty());  // not placed yet
  mosaic.set_pose(3, SE2{});
  mosaic.recompose(true);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      ASSERT_EQ(mosaic.map().at(x - 64, y + 128), cells[static_cast<std::size_t>(y * 64 + x)]);
}

TEST(GridMosaic, OverlapIsEquation7) {
  GridMosaic mosaic(kResolution);
  mosaic.set_tile(1, {0, 0}, all(cell_from_probability(0.7)), kResolution);
  mosaic.set_tile(2, {0, 0}, all(cell_from_probability(0.4)), kResolution);
  mosaic.set_pose(1, SE2{});
  mosaic.set_pose(2, SE2{3.2 / 2, 0, 0});  // half a tile to the right
  mosaic.recompose(true);
  EXPECT_EQ(mosaic.map().at(0, 0), cell_from_probability(0.7));
  EXPECT_EQ(mosaic.map().at(40, 0),
            by_equation_7({probability_from_cell(cell_from_probability(0.7)),
                           probability_from_cell(cell_from_probability(0.4))}));
  EXPECT_EQ(mosaic.map().at(70, 0), cell_from_probability(0.4));
  EXPECT_EQ(mosaic.map().at(0, -1), kUnknownCell);
}

TEST(GridMosaic, RotatedSubmapHasNoHoles) {
  GridMosaic mosaic(kResolution);
  mosaic.set_tile(1, {0, 0}, all(200), kResolution);
  mosaic.set_pose(1, SE2{1.0, -0.5, 0.6});
  mosaic.recompose(true);
  const SE2 inverse = SE2{1.0, -0.5, 0.6}.inverse();
  for (int y = -60; y < 120; ++y)
    for (int x = -60; x < 120; ++x) {
      const Eigen::Vector2d p =
          inverse * Eigen::Vector2d((x + 0.5) * kResolution, (y + 0.5) * kResolution);
      const bool inside = p.minCoeff() >= 0 && p.maxCoeff() < 3.2;
      ASSERT_EQ(mosaic.map().at(x, y), inside ? 200 : kUnknownCell) << x << " " << y;
    }
}

TEST(GridMosaic, IncrementalEqualsFromScratchInAnyOrder) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  GridMosaic incremental(kResolution);
  std::map<std::int64_t, SE2> poses;
  std::map<std::pair<std::int64_t, TileIndex>, TileCells> tiles;
  for (int step = 0; step < 60; ++step) {
    const std::int64_t id = 1 + static_cast<std::int64_t>(random() % 4);
    if (random() % 3 == 0) {
      poses[id] = SE2{2 * uniform(random), 2 * uniform(random), 3 * uniform(random)};
      incremental.set_pose(id, poses[id]);
    } else {
      const TileIndex index{static_cast<int>(random() % 2), static_cast<int>(random() % 2)};
      if (random() % 5 == 0) {
        tiles.erase({id, index});
        incremental.erase_tile(id, index);
      } else {
        tiles[{id, index}] = random_cells(&random);
        incremental.set_tile(id, index, tiles[{id, index}], kResolution);
      }
    }
    if (random() % 2 == 0) incremental.recompose(true);
  }
  incremental.recompose(true);
  GridMosaic scratch(kResolution);
  for (auto it = tiles.rbegin(); it != tiles.rend(); ++it)
    scratch.set_tile(it->first.first, it->first.second, it->second, kResolution);
  for (auto it = poses.rbegin(); it != poses.rend(); ++it) scratch.set_pose(it->first, it->second);
  scratch.recompose(true);
  EXPECT_FALSE(scratch.map().tiles().empty());
  EXPECT_TRUE(scratch.map().tiles() == incremental.map().tiles());
}

// Each cell alone, by the definition; many submaps, so that what older ones say together is
// remembered and must be forgotten again.
TEST(GridMosaic, EqualsLookingUpEachCellAlone) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  GridMosaic mosaic(kResolution);
  std::map<std::int64_t, SE2> poses;
  std::map<std::int64_t, TileCells> tiles;
  for (int step = 0; step < 30; ++step) {
    const std::int64_t id = 1 + static_cast<std::int64_t>(random() % 8);
    poses[id] = SE2{uniform(random), uniform(random), 3 * uniform(random)};
    mosaic.set_pose(id, poses[id]);
    TileCells cells = tiles.count(id) != 0 ? tiles[id] : random_cells(&random);
    for (int i = 0; i < 300; ++i)
      cells[random() % cells.size()] = static_cast<std::uint8_t>(random());
    tiles[id] = cells;
    mosaic.set_tile(id, {0, 0}, cells, kResolution);
    mosaic.recompose(true);
  }
  std::size_t different = 0, known = 0;
  for (int y = -64; y < 128; ++y)
    for (int x = -64; x < 128; ++x) {
      std::vector<double> says;
      for (const auto& [id, cells] : tiles) {
        const Eigen::Vector2d p =
            poses[id].inverse() *
            Eigen::Vector2d((x + 0.5) * kResolution, (y + 0.5) * kResolution) / kResolution;
        const int i = static_cast<int>(std::floor(p.x())), j = static_cast<int>(std::floor(p.y()));
        if (i < 0 || j < 0 || i >= 64 || j >= 64) continue;
        const std::uint8_t cell =
            cells[static_cast<std::size_t>(j) * 64 + static_cast<std::size_t>(i)];
        if (cell != kUnknownCell)
          says.push_back(std::clamp(probability_from_cell(cell), 0.02, 0.98));
      }
      const int expected = says.empty() ? kUnknownCell : by_equation_7(says);
      known += says.empty() ? 0 : 1;
      different += std::abs(mosaic.map().at(x, y) - expected) <= 1 ? 0 : 1;
    }
  EXPECT_GT(known, 4000U);
  EXPECT_LE(different, 20U);  // a centre on an edge may round to either side
}

TEST(GridMosaic, OnlyChangedTilesAreNamed) {
  GridMosaic mosaic(kResolution);
  mosaic.set_tile(1, {0, 0}, all(200), kResolution);
  mosaic.set_pose(1, SE2{});
  EXPECT_EQ(mosaic.recompose(false), (std::set<TileIndex>{{0, 0}}));
  mosaic.set_tile(1, {0, 0}, all(200), kResolution);
  EXPECT_TRUE(mosaic.recompose(false).empty());
}

TEST(GridMosaic, WhatHasGoneIsForgotten) {
  GridMosaic mosaic(kResolution);
  for (int id = 1; id <= 20; ++id) {
    mosaic.set_tile(id, {0, 0}, all(cell_from_probability(0.97)), kResolution);
    mosaic.set_pose(id, SE2{});
  }
  mosaic.recompose(false);
  EXPECT_GT(probability_from_cell(mosaic.map().at(5, 5)), 0.9);
  for (int id = 21; id <= 22; ++id) {  // both growing submaps have seen through it
    mosaic.set_tile(id, {0, 0}, all(cell_from_probability(0.12)), kResolution);
    mosaic.set_pose(id, SE2{});
  }
  mosaic.recompose(false);
  EXPECT_LT(probability_from_cell(mosaic.map().at(5, 5)), 0.65);
}

TEST(GridMosaic, SmallMovesWaitUntilExact) {
  GridMosaic mosaic(kResolution, 0.25);
  mosaic.set_tile(1, {0, 0}, all(200), kResolution);
  mosaic.set_pose(1, SE2{0.02, 0, 0});
  mosaic.recompose(false);
  EXPECT_NE(mosaic.map().at(0, 0), kUnknownCell);
  mosaic.set_pose(1, SE2{0.03, 0, 0});  // a fifth of a cell, over the centre of the first
  EXPECT_TRUE(mosaic.recompose(false).empty());
  EXPECT_EQ(mosaic.recompose(true), (std::set<TileIndex>{{0, 0}, {1, 0}}));
  EXPECT_EQ(mosaic.map().at(0, 0), kUnknownCell);
  EXPECT_TRUE(mosaic.recompose(true).empty());
  mosaic.set_pose(1, SE2{0.03, 0, 0.01});  // the far corner moves by 45 mm
  EXPECT_FALSE(mosaic.recompose(false).empty());
}

// Submaps that no longer grow are packed: composed of them, the map is as of whole ones (a first
// recompose() finds none packed), also when an old one moves or still gets a tile.
TEST(GridMosaic, PackedSubmapsComposeAsWholeOnes) {
  constexpr int kSubmaps = 12;
  std::mt19937 random(4);
  std::vector<TileCells> cells;
  for (int id = 0; id < kSubmaps; ++id) {
    cells.push_back(all(0));
    for (std::size_t i = 0; i < 400; ++i)
      cells.back()[i * 7] = static_cast<std::uint8_t>(random() % 3 == 0 ? 30 : 220);
  }
  const TileCells late = random_cells(&random);
  const auto pose = [](int id) { return SE2{0.31 * id, -0.17 * id, 0.2 * id}; };
  GridMosaic mosaic(kResolution);
  for (int id = 0; id < kSubmaps; ++id) {
    mosaic.set_tile(id, {0, 0}, cells[static_cast<std::size_t>(id)], kResolution);
    mosaic.set_pose(id, pose(id));
    mosaic.recompose(false);
  }
  EXPECT_LT(mosaic.submap_bytes(), kSubmaps * cells[0].size() / 2);
  mosaic.set_pose(1, pose(3));
  mosaic.set_tile(2, {1, 0}, late, kResolution);
  mosaic.erase_tile(5, {0, 0});
  mosaic.recompose(true);

  GridMosaic whole(kResolution);
  for (int id = 0; id < kSubmaps; ++id) {
    if (id != 5) whole.set_tile(id, {0, 0}, cells[static_cast<std::size_t>(id)], kResolution);
    whole.set_pose(id, pose(id == 1 ? 3 : id));
  }
  whole.set_tile(2, {1, 0}, late, kResolution);
  whole.recompose(true);
  EXPECT_EQ(mosaic.map().tiles(), whole.map().tiles());
}

}  // namespace
}  // namespace fusion_slam
