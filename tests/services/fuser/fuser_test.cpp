#include "services/fuser/fuser.hpp"

#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "services/fuser/fusion_rule.hpp"

namespace fusion_slam {
namespace {

constexpr double kResolution = 0.05;

TileCells all(double p) {
  TileCells cells;
  cells.fill(cell_from_probability(p));
  return cells;
}

Tile tile(std::int64_t submap, int x, int y, const TileCells& cells, std::int64_t utime_us) {
  return encode_grid_tile({submap, x, y, 0}, cells, kResolution, 1, utime_us);
}

// What a listener holds after everything that was published.
using Held = std::map<TileKey, Tile>;
void hold(const std::vector<Tile>& tiles, Held* held) {
  for (const Tile& t : tiles) {
    EXPECT_GT(t.revision, (*held)[t.key].revision);
    (*held)[t.key] = t;
  }
}
std::map<TileKey, std::vector<std::uint8_t>> content(const Held& held) {
  std::map<TileKey, std::vector<std::uint8_t>> out;
  for (const auto& [key, t] : held)
    if (t.encoding != TileEncoding::kEmpty) out[key] = t.data;
  return out;
}

TEST(Fuser, CameraAloneGoesThrough) {
  Fuser fuser(kResolution, FuserConfig{});
  EXPECT_TRUE(fuser.add_visual_tile(tile(0, 2, -1, all(0.8), 5)));
  const FuserOutput output = fuser.update(true);
  EXPECT_TRUE(output.lidar.empty());
  ASSERT_EQ(output.fused.size(), 1U);
  EXPECT_EQ(output.fused[0].utime_us, 5);
  const auto cells = decode_fused_tile(output.fused[0]);
  ASSERT_TRUE(cells);
  EXPECT_EQ(cells->probability, all(0.8));
  EXPECT_EQ(cells->provenance[0], 2);
  EXPECT_TRUE(fuser.update(true).fused.empty());  // nothing changed
}

TEST(Fuser, LidarAloneWaitsForItsAnchor) {
  Fuser fuser(kResolution, FuserConfig{});
  EXPECT_TRUE(fuser.add_submap_tile(tile(7, 0, 0, all(0.1), 5)));
  EXPECT_TRUE(fuser.update(true).fused.empty());
  fuser.set_anchor(7, SE3::Identity(), 6);
  const FuserOutput output = fuser.update(true);
  ASSERT_EQ(output.lidar.size(), 1U);
  ASSERT_EQ(output.fused.size(), 1U);
  EXPECT_EQ(*decode_grid_tile(output.lidar[0]), all(0.1));
  EXPECT_EQ(decode_fused_tile(output.fused[0])->provenance[0], 1);
}

TEST(Fuser, BothSensorsByEquation8) {
  Fuser fuser(kResolution, FuserConfig{});
  fuser.add_submap_tile(tile(1, 0, 0, all(0.2), 5));
  fuser.set_anchor(1, SE3::Identity(), 5);
  fuser.add_visual_tile(tile(0, 0, 0, all(0.1), 5));
  const auto cells = decode_fused_tile(fuser.update(true).fused.at(0));
  EXPECT_NEAR(probability_from_cell(cells->probability[0]), 0.02 / 0.74, 0.004);
  EXPECT_EQ(cells->provenance[0], 3);
}

TEST(Fuser, MovedAnchorEmptiesTheTilesItLeft) {
  Fuser fuser(kResolution, FuserConfig{});
  fuser.add_submap_tile(tile(1, 0, 0, all(0.9), 5));
  fuser.set_anchor(1, SE3::Identity(), 5);
  fuser.update(true);
  SE3 far = SE3::Identity();
  far.translation().x() = 32.0;
  fuser.set_anchor(1, far, 6);
  const FuserOutput output = fuser.update(true);
  ASSERT_EQ(output.fused.size(), 2U);
  EXPECT_EQ(output.fused[0].encoding, TileEncoding::kEmpty);
  EXPECT_EQ(output.fused[1].key.x, 10);
}

TEST(Fuser, CameraAtOnceLidarThrottledByTheInputsTime) {
  Fuser fuser(kResolution, FuserConfig{});
  EXPECT_FALSE(fuser.due());  // nothing to say
  fuser.add_submap_tile(tile(1, 0, 0, all(0.8), 10'000'000));
  fuser.set_anchor(1, SE3::Identity(), 10'000'000);
  EXPECT_TRUE(fuser.due());
  EXPECT_EQ(fuser.update(false).lidar.size(), 1U);
  fuser.add_submap_tile(tile(1, 1, 0, all(0.8), 10'900'000));
  EXPECT_FALSE(fuser.due());
  fuser.add_visual_tile(tile(0, 1, 0, all(0.8), 10'900'000));
  EXPECT_TRUE(fuser.due());
  const FuserOutput visual = fuser.update(false);
  EXPECT_TRUE(visual.lidar.empty());
  EXPECT_EQ(visual.fused.size(), 1U);
  EXPECT_FALSE(fuser.due());
  fuser.add_submap_tile(tile(1, 2, 0, all(0.8), 11'000'000));
  EXPECT_TRUE(fuser.due());
  EXPECT_EQ(fuser.update(false).lidar.size(), 2U);
}

// The submaps' ids say which is newer.
TEST(Fuser, WhatTheLidarSeesThroughGoes) {
  Fuser fuser(kResolution, FuserConfig{});
  for (int id = 1; id <= 6; ++id) {
    fuser.add_submap_tile(tile(id, 0, 0, all(0.97), id));
    fuser.set_anchor(id, SE3::Identity(), id);
  }
  Held held;
  hold(fuser.update(true).fused, &held);
  EXPECT_EQ(state_of_cell(decode_fused_tile(held.begin()->second)->probability[0]),
            CellState::kOccupied);
  for (int id = 7; id <= 8; ++id) {
    fuser.add_submap_tile(tile(id, 0, 0, all(0.12), id));
    fuser.set_anchor(id, SE3::Identity(), id);
  }
  hold(fuser.update(true).fused, &held);
  EXPECT_NE(state_of_cell(decode_fused_tile(held.begin()->second)->probability[0]),
            CellState::kOccupied);
}

// Free up to x = 9, then occupied cells: the face and one more stay, the tail of the noise goes,
// also across a tile's edge; what is far from anything free stays, nobody knows better.
TEST(Fuser, NothingIsSeenBehindAFace) {
  Fuser fuser(kResolution, FuserConfig{});
  TileCells cells = all(0.9);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 62; ++x)
      cells[static_cast<std::size_t>(y * 64 + x)] = cell_from_probability(0.1);
  fuser.add_submap_tile(tile(1, 0, 0, cells, 5));
  fuser.add_submap_tile(tile(1, 1, 0, all(0.9), 5));
  fuser.set_anchor(1, SE3::Identity(), 5);
  Held held;
  hold(fuser.update(true).fused, &held);
  const auto state = [&](int x) {
    const auto fused = decode_fused_tile(held.at({0, x >> 6, 0, 0}));
    return state_of_cell(fused->probability[static_cast<std::size_t>(30 * 64 + (x & 63))]);
  };
  EXPECT_EQ(state(61), CellState::kUnoccupied);
  for (const int x : {62, 63}) EXPECT_EQ(state(x), CellState::kOccupied) << x;
  for (const int x : {64, 65, 66}) EXPECT_EQ(state(x), CellState::kUnknown) << x;
  for (const int x : {67, 90}) EXPECT_EQ(state(x), CellState::kOccupied) << x;
}

TEST(Fuser, DamagedAndForeignTilesAreRefused) {
  Fuser fuser(kResolution, FuserConfig{});
  Tile bad = tile(1, 0, 0, all(0.9), 5);
  bad.data.resize(bad.data.size() / 2);
  EXPECT_FALSE(fuser.add_submap_tile(bad));
  EXPECT_FALSE(fuser.add_visual_tile(bad));
  Tile coarse = tile(0, 0, 0, all(0.9), 5);
  coarse.resolution_m = 0.1;
  EXPECT_FALSE(fuser.add_visual_tile(coarse));
  EXPECT_TRUE(fuser.update(true).fused.empty());
}

TEST(Fuser, AnyOrderAndAnyStepsGiveTheSameMap) {
  std::mt19937 random(11);
  struct Input {
    bool visual = false;
    std::optional<Tile> tile;
    std::int64_t submap = 0;
    SE3 anchor = SE3::Identity();
  };
  std::vector<Input> inputs;
  for (int submap = 1; submap <= 3; ++submap)
    for (int x = -1; x < 2; ++x) {
      TileCells cells;
      for (auto& cell : cells) cell = static_cast<std::uint8_t>(random());
      inputs.push_back({false, tile(submap, x, 0, cells, 1000 * submap), 0, SE3::Identity()});
      inputs.push_back({true, tile(0, x, submap - 2, cells, 1000 * submap), 0, SE3::Identity()});
    }
  for (int submap = 1; submap <= 3; ++submap)
    inputs.push_back({false, std::nullopt, submap, to_se3({0.3 * submap, 0.1, 0.7 * submap})});
  std::map<TileKey, std::vector<std::uint8_t>> first;
  for (int trial = 0; trial < 6; ++trial) {
    Fuser fuser(kResolution, FuserConfig{});
    Held lidar, fused;
    for (const Input& input : inputs) {
      if (!input.tile)
        fuser.set_anchor(input.submap, input.anchor, 9000);
      else if (input.visual)
        fuser.add_visual_tile(*input.tile);
      else
        fuser.add_submap_tile(*input.tile);
      if (trial == 0 || random() % 3 != 0) continue;  // trial 0: all at once at the end
      const FuserOutput output = fuser.update(random() % 2 == 0);
      hold(output.lidar, &lidar);
      hold(output.fused, &fused);
    }
    const FuserOutput output = fuser.update(true);
    hold(output.lidar, &lidar);
    hold(output.fused, &fused);
    if (trial == 0) first = content(fused);
    EXPECT_GT(first.size(), 6U);
    EXPECT_TRUE(content(fused) == first) << "trial " << trial;
    std::shuffle(inputs.begin(), inputs.end(), random);
  }
}

}  // namespace
}  // namespace fusion_slam
