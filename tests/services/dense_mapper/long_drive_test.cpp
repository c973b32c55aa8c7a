// The same room again and again: what is kept stops growing, and the map is as good as with all of
// it: it follows the graph, and what is taken away goes.
#include <random>

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

// Submaps of random voxels that lie across each other, against each voxel asked one by one.
TEST(DropSuperseded, DropsWhatASlowCountSays) {
  constexpr int kKeep = 3;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  DenseSubmaps submaps;
  for (std::int64_t id = 1; id <= 8; ++id) {
    DenseSubmap& submap = submaps.try_emplace(id, 0.025).first->second;
    submap.closed = true;
    Eigen::Array<double, 5, 1>
        at;  // one after the other: compilers differ in the order of arguments
    for (double& number : at) number = u(random);
    submap.T_map_submap =
        from_xyz_rpy(0.5 * at[0], 0.5 * at[1], 0.5 * at[2], 0.2 * at[3], 0, at[4]);
    for (const CubeIndex index : {CubeIndex{0, 0, 0}, CubeIndex{-1, 0, 0}, CubeIndex{0, -1, 1}}) {
      if (id == 4 && index.x < 0) continue;
      VoxelCells cells;
      for (std::int8_t& cell : cells)
        cell = u(random) < 0.0 ? kUnknownVoxel : static_cast<std::int8_t>(50 * u(random));
      submap.packed[index] = pack_cells(cells);
    }
    const auto touched = touched_cubes(submap, 0.05);
    submap.touches.assign(touched.begin(), touched.end());
  }
  const auto at = [](const VoxelCubes& cubes, const Eigen::Vector3d& p) {
    const Eigen::Array3i v = p.array().floor().cast<int>();
    const auto it = cubes.find({v.x() >> 5, v.y() >> 5, v.z() >> 5});
    return it == cubes.end() ? kUnknownVoxel
                             : (*it->second)[voxel_index(v.x() & 31, v.y() & 31, v.z() & 31)];
  };
  std::map<std::int64_t, VoxelCubes> all;
  for (const auto& [id, submap] : submaps) all[id] = unpack_cubes(submap.packed);
  EXPECT_FALSE(drop_superseded(2, kKeep, 0.05, 0.025, &submaps));
  const VoxelCubes left = unpack_cubes(submaps.at(2).packed);
  int dropped = 0;
  int kept = 0;
  for (const auto& [index, cells] : all.at(2))
    for (int i = 0; i < kOctomapTileVolume; ++i) {
      const Eigen::Vector3d p =
          Eigen::Vector3d(index.x * 32 + (i & 31), index.y * 32 + (i >> 5 & 31),
                          index.z * 32 + (i >> 10)) +
          Eigen::Vector3d::Constant(0.5);
      if (at(all.at(2), p) == kUnknownVoxel) continue;
      int known = 0;
      for (std::int64_t id = 3; id <= 8; ++id) {
        SE3 T = submaps.at(id).T_map_submap.inverse() * submaps.at(2).T_map_submap;
        T.translation() /= 0.05;
        known += at(all.at(id), T * p) != kUnknownVoxel ? 1 : 0;
      }
      (known >= kKeep ? dropped : kept) += 1;
      ASSERT_EQ(at(left, p), known >= kKeep ? kUnknownVoxel : at(all.at(2), p)) << p.transpose();
    }
  EXPECT_GT(dropped, 1000);
  EXPECT_GT(kept, 1000);
}

}  // namespace
}  // namespace fusion_slam
