// The whole dense part on a real hand-held recording with its reference poses. What must come out
// was read off the pictures: floor 1.38 m below the first camera position, which looks down by
// about 29 degrees; cupboards, a table and chairs.
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "libs/datasets/rgbd_dataset.hpp"
#include "libs/grid/cell_state.hpp"
#include "services/dense_mapper/dense_mapper.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

TEST(RedKitchen, BecomesAFloorPlan) {
  FS_RECORDING(directory, "rgbd/7scenes-redkitchen");
  const RgbdDataset dataset = open_seven_scenes(directory);
  RobotModel robot;
  robot.planar = false;
  robot.T_base_camera.linear() = optical_to_body();
  DenseMapper mapper(dataset.camera, robot, DenseMapperConfig{});
  const SE3 T_base_camera = robot.T_base_camera;
  const SE3 T_map_world = T_base_camera * dataset.reference.at(0).T_world_reference.inverse();
  std::map<std::int64_t, SE3> T_map_base;
  std::int64_t id = 0;
  for (std::size_t i = 0; i < dataset.entries.size(); i += 20) {
    std::string why;
    const auto frame = load_frame(dataset, i, &why);
    ASSERT_TRUE(frame) << why;
    ++id;
    ASSERT_TRUE(mapper.add_keyframe(id, *frame));
    T_map_base[id] =
        T_map_world * dataset.reference.at(i).T_world_reference * T_base_camera.inverse();
    mapper.set_pose(id, T_map_base[id], frame->utime_us);
  }
  mapper.integrate_ready();
  const auto wish = mapper.wish_level(true);
  ASSERT_TRUE(wish);
  EXPECT_TRUE(wish->floor_seen);
  EXPECT_TRUE(mapper.update(true).grid.empty());
  const SE3 T_level_map = levelling(T_map_base.at(wish->anchor_id), wish->T_level_anchor);
  EXPECT_NEAR(T_level_map.translation().z(), 1.38, 0.06);
  EXPECT_NEAR(std::acos(T_level_map.linear()(2, 2)), 0.51, 0.05);
  for (const auto& [keyframe, T] : T_map_base) mapper.set_pose(keyframe, T_level_map * T, 0);
  const DenseTiles tiles = mapper.update(true);
  int occupied = 0;
  int unoccupied = 0;
  for (const Tile& tile : tiles.grid) {
    const auto cells = decode_grid_tile(tile);
    ASSERT_TRUE(cells);
    for (const std::uint8_t cell : *cells) {
      occupied += state_of_cell(cell) == CellState::kOccupied ? 1 : 0;
      unoccupied += state_of_cell(cell) == CellState::kUnoccupied ? 1 : 0;
    }
  }
  EXPECT_GT(occupied, 200);  // 6 m of fronts and a table's legs
  EXPECT_LT(occupied, 1200);
  EXPECT_GT(unoccupied, 700);  // 2 m^2 of floor that were seen often enough
}

}  // namespace
}  // namespace fusion_slam
