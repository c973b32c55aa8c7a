// The process on a private bus: images, models and poses in an awkward order.
#include "services/dense_mapper/dense_mapper_process.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "libs/bus/transport.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

TEST(DenseMapperProcess, MapsWhateverComesFirst) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus bus(test_bus("dense_mapper"), transport);
  Bus world(test_bus("world"), transport);
  const DenseMapperProcess process(bus);
  std::map<TileKey, Tile> grid, octomap, cloud;
  const TileReceiver grid_in(world, "GRID_VISUAL", [&](const Tile& t) { grid[t.key] = t; });
  const TileReceiver octomap_in(world, "OCTOMAP", [&](const Tile& t) { octomap[t.key] = t; });
  const TileReceiver cloud_in(world, "CLOUD", [&](const Tile& t) { cloud[t.key] = t; });
  const auto soon = [&](const auto& condition) {
    for (int i = 0; i < 500 && !condition(); ++i) {
      while (bus.handle(1)) {
      }
      while (world.handle(1)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return condition();
  };

  RobotModel robot;
  robot.T_base_camera.linear() = optical_to_body();
  robot.T_base_camera.translation() = Eigen::Vector3d(0.0, 0.0, 0.35);
  const CameraModel camera = small_camera();
  keyframe_image_t image{};
  image.utime = 1000;
  image.id = 1;
  image.images = to_message(render_room(robot.T_base_camera, camera, 1000));
  world.publish("KEYFRAME_IMAGE", image);
  command_t finish{};
  finish.utime = 2000;
  finish.verb = "finish";
  world.publish("COMMAND", finish);
  world.publish("CAMERA_MODEL", to_message(camera, 1000));
  world.publish("ROBOT_MODEL", to_message(robot, 1000));
  keyframe_image_t damaged = image;
  damaged.id = 2;
  damaged.images.images[0].data.resize(10);
  damaged.images.images[0].size = 10;
  world.publish("KEYFRAME_IMAGE", damaged);
  EXPECT_TRUE(soon([&] { return !bus.status().last_error.empty(); }));
  EXPECT_TRUE(grid.empty());
  EXPECT_NE(bus.status().last_error.find("KEYFRAME_IMAGE 2"), std::string::npos);

  graph_t graph{};
  graph.utime = 1000;
  graph.n_parts = 1;
  graph.n_nodes = 1;
  graph.nodes.resize(1);
  graph.nodes[0].kind = graph_node_t::KEYFRAME;
  graph.nodes[0].id = 1;
  graph.nodes[0].T_map_base = to_message(SE3::Identity(), 1000);
  world.publish("GRAPH", graph);
  EXPECT_TRUE(soon([&] { return !grid.empty() && !octomap.empty() && !cloud.empty(); }));
}

TEST(DenseMapperProcess, ResetEmptiesTheMapAndTheNextBeginsAtAnyId) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus bus(test_bus("dense_mapper"), transport);
  Bus world(test_bus("world"), transport);
  const DenseMapperProcess process(bus);
  std::map<TileKey, Tile> grid, octomap, cloud;
  const TileReceiver grid_in(world, "GRID_VISUAL", [&](const Tile& t) { grid[t.key] = t; });
  const TileReceiver octomap_in(world, "OCTOMAP", [&](const Tile& t) { octomap[t.key] = t; });
  const TileReceiver cloud_in(world, "CLOUD", [&](const Tile& t) { cloud[t.key] = t; });
  const auto soon = [&](const auto& condition) {
    for (int i = 0; i < 5000 && !condition(); ++i) {
      while (bus.handle(1)) {
      }
      while (world.handle(1)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return condition();
  };
  const auto alive = [](const std::map<TileKey, Tile>& tiles) {
    return std::count_if(tiles.begin(), tiles.end(), [](const auto& entry) {
      return entry.second.encoding != TileEncoding::kEmpty;
    });
  };
  RobotModel robot;
  robot.T_base_camera.linear() = optical_to_body();
  robot.T_base_camera.translation() = Eigen::Vector3d(0.0, 0.0, 0.35);
  const CameraModel camera = small_camera();
  const auto see = [&](std::int64_t id, std::int64_t utime_us) {
    keyframe_image_t image{};
    image.utime = utime_us;
    image.id = id;
    image.images = to_message(render_room(robot.T_base_camera, camera, utime_us));
    world.publish("KEYFRAME_IMAGE", image);
    graph_t graph{};
    graph.utime = utime_us;
    graph.n_parts = 1;
    graph.n_nodes = 1;
    graph.nodes.resize(1);
    graph.nodes[0].kind = graph_node_t::KEYFRAME;
    graph.nodes[0].id = id;
    graph.nodes[0].utime = utime_us;
    graph.nodes[0].T_map_base = to_message(SE3::Identity(), utime_us);
    world.publish("GRAPH", graph);
  };
  const auto say = [&](const char* verb, std::int64_t utime_us) {
    command_t command{};
    command.utime = utime_us;
    command.verb = verb;
    world.publish("COMMAND", command);
  };
  world.publish("CAMERA_MODEL", to_message(camera, 1000));
  world.publish("ROBOT_MODEL", to_message(robot, 1000));
  see(1, 1'000'000);
  say("finish", 1'500'000);
  ASSERT_TRUE(soon([&] { return alive(grid) > 0 && alive(octomap) > 0 && alive(cloud) > 0; }));
  const auto before = alive(octomap);
  say("reset", 2'000'000);
  ASSERT_TRUE(soon([&] { return alive(grid) + alive(octomap) + alive(cloud) == 0; }));
  see(2, 1'900'000);  // was under way: of the old map
  see(3, 3'000'000);  // not the first of a submap by its number
  say("finish", 3'500'000);
  ASSERT_TRUE(soon([&] { return alive(grid) > 0 && alive(octomap) > 0 && alive(cloud) > 0; }));
  EXPECT_EQ(alive(octomap), before);
  EXPECT_TRUE(bus.status().last_error.empty()) << bus.status().last_error;
}

}  // namespace
}  // namespace fusion_slam
