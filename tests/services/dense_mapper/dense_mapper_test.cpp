#include "services/dense_mapper/dense_mapper.hpp"

#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "libs/grid/cell_state.hpp"
#include "libs/octree/octomap_tile.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"

namespace fusion_slam {
namespace {

RobotModel wheeled() {
  RobotModel robot;
  robot.has_camera = true;
  robot.T_base_camera.linear() = optical_to_body();
  robot.T_base_camera.translation() = Eigen::Vector3d(0.1, 0.0, 0.35);
  return robot;
}

// Seven keyframes: a short way towards the wall, looking a little left and right.
std::map<std::int64_t, SE3> drive() {
  std::map<std::int64_t, SE3> poses;
  for (int i = 0; i < 7; ++i)
    poses[i + 1] = to_se3(SE2{-1.2 + 0.15 * i, 0.05 * (i % 3), 0.25 * (i % 3 - 1)});
  return poses;
}

struct World {
  CameraModel camera = small_camera();
  RobotModel robot = wheeled();
  std::map<std::int64_t, SE3> poses = drive();
  RgbdFrame frame(std::int64_t id) const {
    return render_room(poses.at(id) * robot.T_base_camera, camera, 1000 * id);
  }
  DenseMapper mapper() const { return {camera, robot, DenseMapperConfig{}}; }
};

using Held = std::map<TileKey, Tile>;
void hold(const std::vector<Tile>& tiles, Held* held) {
  for (const Tile& tile : tiles) {
    EXPECT_GT(tile.revision, (*held)[tile.key].revision);
    EXPECT_LT(tile.data.size(), 50000U);
    (*held)[tile.key] = tile;
  }
}
struct Maps {
  Held octomap, cloud, grid;
  void take(const DenseTiles& tiles) {
    hold(tiles.octomap, &octomap);
    hold(tiles.cloud, &cloud);
    hold(tiles.grid, &grid);
  }
  std::vector<std::vector<std::uint8_t>> bytes() const {
    std::vector<std::vector<std::uint8_t>> out;
    for (const Held* held : {&octomap, &cloud, &grid})
      for (const auto& [key, tile] : *held)
        if (tile.encoding != TileEncoding::kEmpty) out.push_back(tile.data);
    return out;
  }
  CellState state(double x_m, double y_m) const {
    TiledGrid all(0.05);
    for (const auto& [key, tile] : grid)
      if (const auto cells = decode_grid_tile(tile)) all.tiles()[{key.x, key.y}] = *cells;
    return state_of_cell(all.at(all.cell_of(x_m), all.cell_of(y_m)));
  }
  // A surface shows in the cell on either side of it.
  bool surface_at(double x_m, double y_m) const {
    return state(x_m - 0.025, y_m) == CellState::kOccupied ||
           state(x_m + 0.025, y_m) == CellState::kOccupied;
  }
};

Maps map_in_order(const World& world, const std::map<std::int64_t, SE3>& poses) {
  DenseMapper mapper = world.mapper();
  for (const auto& [id, T] : poses) {
    EXPECT_TRUE(mapper.add_keyframe(id, world.frame(id)));
    mapper.set_pose(id, T, 1000 * id);
  }
  mapper.integrate_ready();
  Maps maps;
  maps.take(mapper.update(true));
  return maps;
}

TEST(DenseMapper, RoomBecomesItsFloorPlan) {
  const World world;
  const Maps maps = map_in_order(world, world.poses);
  for (const double y : {-0.6, 0.0, 0.6}) EXPECT_TRUE(maps.surface_at(2.5, y)) << "wall at " << y;
  for (const double y : {-0.12, 0.0, 0.12}) EXPECT_TRUE(maps.surface_at(1.5, y)) << "box at " << y;
  EXPECT_EQ(maps.state(0.8, 0.0), CellState::kUnoccupied);
  EXPECT_EQ(maps.state(1.7, 0.6), CellState::kUnoccupied);  // beside the box
  EXPECT_EQ(maps.state(3.0, 0.0), CellState::kUnknown);     // behind the wall
  EXPECT_EQ(maps.state(-2.0, 0.0), CellState::kUnknown);    // behind the robot
  std::size_t points = 0;
  for (const auto& [key, tile] : maps.cloud) points += decode_cloud_tile(tile)->size();
  EXPECT_GT(points, 1000U);
  EXPECT_FALSE(maps.octomap.empty());
}

TEST(DenseMapper, ArrivalOrderDoesNotMatter) {
  const World world;
  const auto expected = map_in_order(world, world.poses).bytes();
  std::mt19937 random(3);
  std::vector<std::pair<bool, std::int64_t>> events;  // pose or image, of a keyframe
  for (const auto& [id, T] : world.poses) {
    events.emplace_back(true, id);
    events.emplace_back(false, id);
  }
  for (int trial = 0; trial < 4; ++trial) {
    std::shuffle(events.begin(), events.end(), random);
    DenseMapper mapper = world.mapper();
    Maps maps;
    for (const auto& [is_pose, id] : events) {
      if (is_pose)
        mapper.set_pose(id, world.poses.at(id), 1000 * id);
      else
        mapper.add_keyframe(id, world.frame(id));
      mapper.integrate_ready();
      if (trial % 2 == 0 && random() % 3 == 0) maps.take(mapper.update(false));
    }
    EXPECT_EQ(mapper.waiting(), 0U);
    maps.take(mapper.update(true));
    EXPECT_TRUE(maps.bytes() == expected) << "trial " << trial;
  }
}

// After a reset ids count on.
TEST(DenseMapper, AMapThatBeginsWithAnyKeyframeIsTheSame) {
  const World world;
  const auto map_from = [&](std::int64_t first) {
    DenseMapper mapper = world.mapper();
    mapper.begin_at(first);
    Maps maps;
    for (const auto& [id, pose] : world.poses) {
      EXPECT_TRUE(mapper.add_keyframe(first - 1 + id, world.frame(id)));
      mapper.set_pose(first - 1 + id, pose, 1000 * id);
      mapper.integrate_ready();
      if (mapper.due()) maps.take(mapper.update(false));
    }
    EXPECT_FALSE(maps.cloud.empty());  // a submap is full
    return maps.bytes();
  };
  EXPECT_EQ(map_from(1), map_from(18));
}

TEST(DenseMapper, MovedAnchorsMoveTheMapWithoutImages) {
  const World world;
  const SE3 correction = from_xyz_rpy(0.8, -0.4, 0.0, 0.0, 0.0, 0.5);
  std::map<std::int64_t, SE3> moved = world.poses;
  for (auto& [id, T] : moved) T = correction * T;
  DenseMapper mapper = world.mapper();
  Maps maps;
  for (const auto& [id, T] : world.poses) {
    mapper.add_keyframe(id, world.frame(id));
    mapper.set_pose(id, T, 1000 * id);
  }
  mapper.integrate_ready();
  maps.take(mapper.update(false));
  EXPECT_FALSE(mapper.due());
  for (const auto& [id, T] : moved) mapper.set_pose(id, T, 9'000'000);
  EXPECT_TRUE(mapper.due());
  maps.take(mapper.update(true));
  const Eigen::Vector3d wall = correction * Eigen::Vector3d(2.5, 0.3, 0.0);
  const Eigen::Vector3d floor = correction * Eigen::Vector3d(0.8, 0.0, 0.0);
  EXPECT_TRUE(maps.surface_at(wall.x(), wall.y()));
  EXPECT_EQ(maps.state(floor.x(), floor.y()), CellState::kUnoccupied);
  const Maps direct = map_in_order(world, moved);
  EXPECT_EQ(maps.bytes().size(), direct.bytes().size());
  EXPECT_TRUE(mapper.update(true).grid.empty());  // nothing new
}

TEST(DenseMapper, WaitsForPosesAndRefusesWhatDoesNotFit) {
  const World world;
  DenseMapper mapper = world.mapper();
  EXPECT_TRUE(mapper.add_keyframe(2, world.frame(2)));
  EXPECT_FALSE(mapper.add_keyframe(2, world.frame(2)));
  EXPECT_FALSE(mapper.add_keyframe(0, world.frame(1)));
  EXPECT_FALSE(mapper.add_keyframe(3, RgbdFrame{}));
  mapper.set_pose(2, world.poses.at(2), 1);
  mapper.integrate_ready();
  EXPECT_EQ(mapper.waiting(), 1U);  // its anchor, keyframe 1, has no pose yet
  mapper.set_pose(1, world.poses.at(1), 2);
  mapper.integrate_ready();
  EXPECT_EQ(mapper.waiting(), 0U);
  EXPECT_EQ(mapper.integrated(), 1U);
}

TEST(DenseMapper, ALateKeyframeIsNotLost) {
  const World world;
  DenseMapper late = world.mapper();
  Maps maps;
  for (const auto& [id, T] : world.poses) {
    late.set_pose(id, T, 1000 * id);
    if (id == 3) continue;
    late.add_keyframe(id, world.frame(id));
    late.integrate_ready();
    maps.take(late.update(false));
  }
  maps.take(late.update(true));
  late.add_keyframe(3, world.frame(3));
  late.integrate_ready();
  EXPECT_TRUE(late.due());
  maps.take(late.update(true));
  EXPECT_EQ(late.integrated(), world.poses.size());
  const Maps expected = map_in_order(world, world.poses);
  EXPECT_EQ(maps.grid.size(), expected.grid.size());
  EXPECT_TRUE(maps.surface_at(2.5, 0.3));
}

// The box is taken away; the camera looks where it was. At 2 to 3 keyframes a second ten are 5 s.
TEST(DenseMapper, WhatTheCameraSeesThroughGoes) {
  const World world;
  DenseMapper mapper = world.mapper();
  Maps maps;
  const auto look = [&](std::int64_t id, bool box) {
    const SE3 T = to_se3(SE2{-1.0 + 0.02 * static_cast<double>(id % 5), 0.0, 0.0});
    const SE3 T_room_camera = T * world.robot.T_base_camera;
    mapper.add_keyframe(id, box ? render_room(T_room_camera, world.camera, id)
                                : render_room(T_room_camera, world.camera, id, false));
    mapper.set_pose(id, T, 100'000 * id);
    mapper.integrate_ready();
    maps.take(mapper.update(false));
  };
  for (std::int64_t id = 1; id <= 20; ++id) look(id, true);
  for (const double y : {-0.1, 0.0, 0.1}) EXPECT_TRUE(maps.surface_at(1.5, y));
  std::size_t before = 0, after = 0;
  const auto count = [&] {
    std::size_t n = 0;
    for (const auto& [key, tile] : maps.cloud) {
      const auto points = decode_cloud_tile(tile);
      if (!points) continue;
      n += static_cast<std::size_t>(
          std::count_if(points->begin(), points->end(), [](const ColouredPoint& point) {
            return std::abs(point.p_m.x() - 1.5F) < 0.04F && std::abs(point.p_m.y()) < 0.15F &&
                   point.p_m.z() > 0.1F;
          }));
    }
    return n;
  };
  before = count();
  for (std::int64_t id = 21; id <= 35; ++id) look(id, false);
  for (const double y : {-0.1, 0.0, 0.1}) EXPECT_FALSE(maps.surface_at(1.5, y)) << y;
  maps.take(mapper.update(true));
  after = count();
  EXPECT_GT(before, 8U);
  EXPECT_LE(after, 1U);
}

// Round and round in one room: what is kept grows much less than time, which doubles here.
TEST(DenseMapper, MemoryIsBoundedByTheArea) {
  const World world;
  DenseMapper mapper = world.mapper();
  std::size_t at_half = 0;
  for (std::int64_t id = 1; id <= 180; ++id) {  // 36 submaps of one place
    const SE3 T = to_se3(
        SE2{-1.2 + 0.15 * static_cast<double>(id % 7), 0.0, 0.1 * static_cast<double>(id % 3 - 1)});
    mapper.add_keyframe(id, render_room(T * world.robot.T_base_camera, world.camera, id));
    mapper.set_pose(id, T, 400'000 * id);
    mapper.integrate_ready();
    mapper.update(false);
    if (id == 90) at_half = mapper.submap_bytes() + mapper.map_bytes();
  }
  EXPECT_GT(at_half, 0U);
  EXPECT_LT(static_cast<double>(mapper.submap_bytes() + mapper.map_bytes()),
            1.3 * static_cast<double>(at_half));
}

}  // namespace
}  // namespace fusion_slam
