// The same room again and again: what is kept stops growing, and the map is as good as with all of
// it: it follows the graph, and what is taken away goes.
#include <gtest/gtest.h>

#include "libs/grid/cell_state.hpp"
#include "services/dense_mapper/dense_mapper.hpp"
#include "services/dense_mapper/supersede.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"

namespace fusion_slam {
namespace {

constexpr int kViews = 6;  // a lap

class LongDrive : public testing::Test {
 protected:
  static DenseMapperConfig config() {
    DenseMapperConfig config;
    config.keyframes_per_submap = 1;
    config.submaps_that_count = 2;
    config.submaps_over_map = 1.0;
    return config;
  }
  static SE3 view(std::int64_t id) {
    const auto i = static_cast<double>(id % kViews);
    return from_xyz_rpy(-0.6 + 0.1 * i, 0.05 * i, 0, 0, 0, 0.1 * (i - 2));
  }
  void lap(bool with_box) {
    for (int i = 0; i < kViews; ++i) {
      const std::int64_t id = ++id_;
      EXPECT_TRUE(mapper_.add_keyframe(
          id, render_room(view(id) * robot_.T_base_camera, camera_, 1000 * id, with_box)));
      mapper_.set_pose(id, view(id), 1000 * id);
      mapper_.integrate_ready();
      take(mapper_.update(false));
    }
  }
  void take(const DenseTiles& tiles) {
    for (const Tile& tile : tiles.grid) {
      const auto cells = decode_grid_tile(tile);
      if (cells)
        grid_.tiles()[{tile.key.x, tile.key.y}] = *cells;
      else
        grid_.tiles().erase({tile.key.x, tile.key.y});
    }
  }
  CellState state(double x_m, double y_m) const {
    return state_of_cell(grid_.at(grid_.cell_of(x_m), grid_.cell_of(y_m)));
  }
  bool surface_at(double x_m, double y_m) const {
    return state(x_m - 0.025, y_m) == CellState::kOccupied ||
           state(x_m + 0.025, y_m) == CellState::kOccupied;
  }

  RobotModel robot_ = robot_with_camera_at(0.1);
  CameraModel camera_ = small_camera();
  DenseMapper mapper_{camera_, robot_, config()};
  TiledGrid grid_{0.05};
  std::int64_t id_ = 0;
};

TEST_F(LongDrive, MemoryGrowsWithTheAreaAndTheMapStaysWhatItWas) {
  for (int i = 0; i < 3; ++i) lap(true);
  const std::size_t early = mapper_.submap_bytes();
  const std::size_t early_map = mapper_.map_bytes();
  for (int i = 0; i < 4; ++i) lap(true);
  EXPECT_LT(mapper_.submap_bytes(), early + early / 5);
  EXPECT_LT(mapper_.map_bytes(), early_map + early_map / 10);
  EXPECT_LT(mapper_.submaps(), 3U * kViews) << "those of which nothing is left are forgotten";

  // The graph moves everything: composed again from what is left.
  for (std::int64_t id = 1; id <= id_; ++id)
    mapper_.set_pose(id, from_xyz_rpy(0.5, 0.25, 0, 0, 0, 0) * view(id), 2'000'000);
  take(mapper_.update(true));
  for (const double y : {-0.3, 0.0, 0.3}) EXPECT_TRUE(surface_at(3.0, 0.25 + y)) << y;
  EXPECT_EQ(state(2.5, -0.3), CellState::kUnoccupied) << "the wall was there";
  for (const double y : {-0.12, 0.0, 0.12}) EXPECT_TRUE(surface_at(2.0, 0.25 + y)) << y;
  EXPECT_EQ(state(1.3, 0.25), CellState::kUnoccupied);
}

TEST_F(LongDrive, WhatIsTakenAwayGoes) {
  for (int i = 0; i < 3; ++i) lap(true);
  ASSERT_TRUE(surface_at(1.5, 0.0));
  for (int i = 0; i < 2; ++i) lap(false);  // of one keyframe a submap: 9 outweigh any number
  EXPECT_FALSE(surface_at(1.5, 0.0));
  for (const bool exact : {false, true}) {
    take(mapper_.update(exact));
    EXPECT_FALSE(surface_at(1.5, 0.0)) << exact;
    EXPECT_TRUE(surface_at(2.5, 0.0)) << exact;
  }
}

TEST(Ripest, IsTheLargeOneThatGatheredMuchAndWasLookedAtSeldom) {
  DenseSubmaps submaps;
  for (int id = 1; id <= 4; ++id) {
    DenseSubmap& submap = submaps.emplace(id, DenseSubmap(0.025)).first->second;
    submap.closed = true;
    submap.packed[{0, 0, 0}].resize(100);
    submap.newer = 10;
  }
  EXPECT_EQ(ripest(11, submaps), 0);
  EXPECT_EQ(ripest(10, submaps), 1) << "the oldest of equals";
  submaps.at(3).packed[{1, 0, 0}].resize(50);
  EXPECT_EQ(ripest(10, submaps), 3);
  submaps.at(3).visits = 1;
  submaps.at(2).newer = 14;
  EXPECT_EQ(ripest(10, submaps), 2);
  submaps.at(2).closed = false;
  EXPECT_EQ(ripest(10, submaps), 1);
}

}  // namespace
}  // namespace fusion_slam
