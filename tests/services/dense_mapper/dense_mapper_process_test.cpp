// The process on a private bus: images, models and poses in an awkward order.
#include "services/dense_mapper/dense_mapper_process.hpp"

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

}  // namespace
}  // namespace fusion_slam
