// A hand-held camera: no grid before the map is level, one question, and then the right grid.
#include <gtest/gtest.h>

#include "libs/grid/cell_state.hpp"
#include "services/dense_mapper/dense_mapper.hpp"
#include "tests/services/dense_mapper/carried_camera.hpp"

namespace fusion_slam {
namespace {

struct Carried {
  std::map<std::int64_t, SE3> T_room_base = carry(10);
  SE3 T_map_room = T_room_base.at(1).inverse();
  DenseMapper mapper{small_camera(), carried_robot(), DenseMapperConfig{}};

  void see(std::int64_t first, std::int64_t last) {
    for (std::int64_t id = first; id <= last; ++id) {
      const SE3 T_room_camera = T_room_base.at(id) * carried_robot().T_base_camera;
      EXPECT_TRUE(mapper.add_keyframe(id, render_room(T_room_camera, small_camera(), 1000 * id)));
      mapper.set_pose(id, T_map_room * T_room_base.at(id), 1000 * id);
    }
    mapper.integrate_ready();
  }
  // As the pose graph does it.
  void move_map(const SE3& L) {
    T_map_room = L * T_map_room;
    for (std::int64_t id = 1; id <= static_cast<std::int64_t>(mapper.integrated()); ++id)
      mapper.set_pose(id, T_map_room * T_room_base.at(id), 20'000);
  }
};

CellState state(const DenseTiles& tiles, const Eigen::Vector3d& p) {
  TiledGrid all(0.05);
  for (const Tile& tile : tiles.grid)
    if (const auto cells = decode_grid_tile(tile)) all.tiles()[{tile.key.x, tile.key.y}] = *cells;
  return state_of_cell(all.at(all.cell_of(p.x()), all.cell_of(p.y())));
}

TEST(WishLevel, NoGridUntilTheMapIsLevelAndOneQuestion) {
  Carried world;
  world.see(1, 5);
  const auto wish = world.mapper.wish_level(false);
  ASSERT_TRUE(wish);
  EXPECT_EQ(wish->anchor_id, 1);
  EXPECT_TRUE(wish->floor_seen);
  EXPECT_NEAR(wish->T_level_anchor.translation().z(), kCarriedHeightM, 0.03);
  EXPECT_NEAR(wish->T_level_anchor.linear()(2, 0), -std::sin(kCarriedPitchRad), 0.01);
  EXPECT_NEAR(wish->T_level_anchor.linear()(2, 1), 0.0, 0.01);
  EXPECT_FALSE(world.mapper.wish_level(false));  // once
  EXPECT_FALSE(world.mapper.wish_level(true));   // even then: nothing new was seen
  EXPECT_FALSE(world.mapper.level());
  const DenseTiles tiles = world.mapper.update(false);
  EXPECT_TRUE(tiles.grid.empty());
  EXPECT_FALSE(tiles.octomap.empty());

  world.move_map(from_xyz_rpy(0, 0, 0.3, 0, 0, 0));  // a loop closure, not what was asked for
  EXPECT_FALSE(world.mapper.level());
  EXPECT_TRUE(world.mapper.update(true).grid.empty());
}

TEST(WishLevel, TheGridIsRightInTheLevelMap) {
  Carried world;
  world.see(1, 10);
  const auto wish = world.mapper.wish_level(false);
  ASSERT_TRUE(wish);
  EXPECT_TRUE(world.mapper.update(false).grid.empty());
  EXPECT_FALSE(world.mapper.due());
  world.move_map(levelling(world.T_map_room * world.T_room_base.at(1), wish->T_level_anchor));
  EXPECT_TRUE(world.mapper.level());
  EXPECT_TRUE(world.mapper.due());
  EXPECT_FALSE(world.mapper.wish_level(true));
  const DenseTiles tiles = world.mapper.update(true);
  EXPECT_FALSE(world.mapper.due());
  const auto at = [&](double x, double y) {
    return state(tiles, world.T_map_room * Eigen::Vector3d(x, y, 0.0));
  };
  // The box's front or the cell before it; the floor's band was seen free before and beside it.
  EXPECT_TRUE(at(1.48, 0.0) == CellState::kOccupied || at(1.52, 0.0) == CellState::kOccupied);
  EXPECT_EQ(at(1.2, 0.0), CellState::kUnoccupied);
  EXPECT_EQ(at(1.65, 0.4), CellState::kUnoccupied);
  EXPECT_EQ(at(3.0, 0.0), CellState::kUnknown);
  for (const Tile& tile : tiles.octomap) {  // the floor is the lowest there is, flat at z = 0
    if (tile.encoding == TileEncoding::kEmpty) continue;
    EXPECT_GE(tile.key.z, -1);
  }
}

TEST(WishLevel, ALevelMapIsLeftAlone) {
  Carried world;
  world.T_map_room = from_xyz_rpy(0.4, 0.3, 0.0, 0.0, 0.0, 0.8);
  world.see(1, 10);
  EXPECT_FALSE(world.mapper.wish_level(false));
  EXPECT_TRUE(world.mapper.level());
  EXPECT_FALSE(world.mapper.update(true).grid.empty());
}

TEST(WishLevel, AWishThatWasLostIsRepeatedWhenTheDataHaveDoubled) {
  Carried world;
  world.see(1, 4);
  ASSERT_TRUE(world.mapper.wish_level(false));
  world.see(5, 7);
  EXPECT_FALSE(world.mapper.wish_level(false));
  world.see(8, 8);
  EXPECT_TRUE(world.mapper.wish_level(false));
}

TEST(WishLevel, APlanarRobotNeverAsks) {
  Carried world;
  RobotModel robot = carried_robot();
  robot.planar = true;
  world.mapper = DenseMapper(small_camera(), robot, DenseMapperConfig{});
  world.see(1, 10);
  EXPECT_FALSE(world.mapper.wish_level(true));
  EXPECT_TRUE(world.mapper.level());
}

}  // namespace
}  // namespace fusion_slam
