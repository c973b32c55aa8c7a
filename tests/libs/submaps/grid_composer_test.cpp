#include "libs/submaps/grid_composer.hpp"

#include <cmath>
#include <random>

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
  for (const double s : probabilities) p = s * p / (s * p + (1 - s) * (1 - p));
  return cell_from_probability(p);
}

TEST(GridComposer, OneSubmapAtTheOriginIsCopied) {
  GridComposer composer(kResolution);
  std::mt19937 random(1);
  TileCells cells = random_cells(&random);
  for (auto& cell : cells)
    if (cell != 0 && (cell < 10 || cell > 245)) cell = 128;  // within the clamping bounds
  composer.set_tile(3, {-1, 2}, cells, kResolution);
  EXPECT_TRUE(composer.recompose(true).empty());  // not placed yet
  composer.set_pose(3, SE2{});
  composer.recompose(true);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      ASSERT_EQ(composer.map().at(x - 64, y + 128), cells[static_cast<std::size_t>(y * 64 + x)]);
}

TEST(GridComposer, OverlapIsEquation7) {
  GridComposer composer(kResolution);
  composer.set_tile(1, {0, 0}, all(cell_from_probability(0.7)), kResolution);
  composer.set_tile(2, {0, 0}, all(cell_from_probability(0.4)), kResolution);
  composer.set_pose(1, SE2{});
  composer.set_pose(2, SE2{3.2 / 2, 0, 0});  // half a tile to the right
  composer.recompose(true);
  EXPECT_EQ(composer.map().at(0, 0), cell_from_probability(0.7));
  EXPECT_EQ(composer.map().at(40, 0),
            by_equation_7({probability_from_cell(cell_from_probability(0.7)),
                           probability_from_cell(cell_from_probability(0.4))}));
  EXPECT_EQ(composer.map().at(70, 0), cell_from_probability(0.4));
  EXPECT_EQ(composer.map().at(0, -1), kUnknownCell);
}

TEST(GridComposer, RotatedSubmapHasNoHoles) {
  GridComposer composer(kResolution);
  composer.set_tile(1, {0, 0}, all(200), kResolution);
  composer.set_pose(1, SE2{1.0, -0.5, 0.6});
  composer.recompose(true);
  const SE2 inverse = SE2{1.0, -0.5, 0.6}.inverse();
  for (int y = -60; y < 120; ++y)
    for (int x = -60; x < 120; ++x) {
      const Eigen::Vector2d p =
          inverse * Eigen::Vector2d((x + 0.5) * kResolution, (y + 0.5) * kResolution);
      const bool inside = p.minCoeff() >= 0 && p.maxCoeff() < 3.2;
      ASSERT_EQ(composer.map().at(x, y), inside ? 200 : kUnknownCell) << x << " " << y;
    }
}

TEST(GridComposer, IncrementalEqualsFromScratchInAnyOrder) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  GridComposer incremental(kResolution);
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
  GridComposer scratch(kResolution);
  for (auto it = tiles.rbegin(); it != tiles.rend(); ++it)
    scratch.set_tile(it->first.first, it->first.second, it->second, kResolution);
  for (auto it = poses.rbegin(); it != poses.rend(); ++it) scratch.set_pose(it->first, it->second);
  scratch.recompose(true);
  EXPECT_FALSE(scratch.map().tiles().empty());
  EXPECT_TRUE(scratch.map().tiles() == incremental.map().tiles());
}

TEST(GridComposer, SmallMovesWaitUntilExact) {
  GridComposer composer(kResolution, 0.25);
  composer.set_tile(1, {0, 0}, all(200), kResolution);
  composer.set_pose(1, SE2{});
  composer.recompose(false);
  composer.set_pose(1, SE2{0.01, 0, 0});  // a fifth of a cell
  EXPECT_TRUE(composer.recompose(false).empty());
  EXPECT_FALSE(composer.recompose(true).empty());
  EXPECT_TRUE(composer.recompose(true).empty());
  composer.set_pose(1, SE2{0.01, 0, 0.01});  // the far corner moves by 45 mm
  EXPECT_FALSE(composer.recompose(false).empty());
}

}  // namespace
}  // namespace fusion_slam
