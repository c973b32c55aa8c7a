// Dense mapper and pose graph together on a private bus: a tilted map is asked for, levelled, and
// composed, although all of that begins with COMMAND finish.
#include <chrono>
#include <map>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "libs/bus/transport.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/dense_mapper/dense_mapper_process.hpp"
#include "services/pose_graph/pose_graph_process.hpp"
#include "tests/services/dense_mapper/carried_camera.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

TEST(LevelWithPoseGraph, AllOutputsShareTheLevelMap) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus dense_bus(test_bus("dense_mapper", Mode::kThroughput), transport);
  Bus graph_bus(test_bus("pose_graph", Mode::kThroughput), transport);
  Bus world(test_bus("world", Mode::kThroughput), transport);
  const DenseMapperProcess dense(dense_bus);
  const PoseGraphProcess graph(graph_bus);
  std::map<TileKey, Tile> grid;
  std::map<std::int64_t, SE3> T_map_base;
  int wishes = 0;
  const TileReceiver grid_in(world, "GRID_VISUAL", [&](const Tile& t) { grid[t.key] = t; });
  world.subscribe<graph_t>("GRAPH", Policy::kKeepAll, [&](const graph_t& m) {
    for (const graph_node_t& node : m.nodes) T_map_base[node.id] = *from_message(node.T_map_base);
  });
  world.subscribe<constraint_t>("LEVEL", Policy::kKeepAll, [&](const constraint_t&) { ++wishes; });
  const auto soon = [&](const auto& condition) {
    for (int i = 0; i < 1000 && !condition(); ++i) {
      for (Bus* bus : {&graph_bus, &dense_bus, &world})
        while (bus->handle(1)) {
        }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return condition();
  };

  const RobotModel robot = carried_robot();
  const CameraModel camera = small_camera();
  world.publish("CAMERA_MODEL", to_message(camera, 1000));
  world.publish("ROBOT_MODEL", to_message(robot, 1000));
  const auto poses = carry(3);  // fewer than are published without being asked
  for (const auto& [id, T_room_base] : poses) {
    keyframe_t keyframe{};
    keyframe.utime = 1000 * id;
    keyframe.id = id;
    keyframe.previous_id = id - 1;
    const SE3 T_previous = id == 1 ? SE3::Identity() : poses.at(id - 1).inverse() * T_room_base;
    keyframe.T_odom_base = to_message(poses.at(1).inverse() * T_room_base, keyframe.utime);
    keyframe.T_previous_base = to_message(T_previous, keyframe.utime);
    to_message(Matrix6d::Identity() * 1e-5, keyframe.covariance);
    world.publish("KEYFRAME", keyframe);
    keyframe_image_t image{};
    image.utime = keyframe.utime;
    image.id = id;
    image.images = to_message(render_room(T_room_base * robot.T_base_camera, camera, image.utime));
    world.publish("KEYFRAME_IMAGE", image);
  }
  ASSERT_TRUE(soon([&] { return T_map_base.size() == 3; }));
  EXPECT_NEAR(T_map_base.at(1).translation().z(), 0.0, 1e-9);
  command_t finish{};
  finish.utime = 5000;
  finish.verb = "finish";
  world.publish("COMMAND", finish);
  ASSERT_TRUE(soon([&] { return !grid.empty(); }));
  EXPECT_EQ(wishes, 1);
  for (const auto& [id, T_room_base] : poses) {
    EXPECT_NEAR(T_map_base.at(id).translation().z(), T_room_base.translation().z(), 0.04);
    EXPECT_LT((T_map_base.at(id).linear().row(2) - T_room_base.linear().row(2)).norm(), 0.02);
  }
}

}  // namespace
}  // namespace fusion_slam
