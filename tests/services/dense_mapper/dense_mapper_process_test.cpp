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

using Tiles = std::map<TileKey, Tile>;

auto alive(const Tiles& tiles) {
  return std::count_if(tiles.begin(), tiles.end(), [](const auto& entry) {
    return entry.second.encoding != TileEncoding::kEmpty;
  });
}

// The dense mapper, and the world that it hears and that hears it.
class DenseMapperProcessTest : public testing::Test {
 protected:
  DenseMapperProcessTest() {
    robot_.T_base_camera.linear() = optical_to_body();
    robot_.T_base_camera.translation() = Eigen::Vector3d(0.0, 0.0, 0.35);
  }

  template <typename Condition>
  bool soon(const Condition& condition) {
    for (int i = 0; i < 5000 && !condition(); ++i) {
      while (bus_.handle(1)) {
      }
      while (world_.handle(1)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return condition();
  }

  void publish_models() {
    world_.publish("CAMERA_MODEL", to_message(camera_, 1000));
    world_.publish("ROBOT_MODEL", to_message(robot_, 1000));
  }
  keyframe_image_t image(std::int64_t id, std::int64_t utime_us) const {
    keyframe_image_t image{};
    image.utime = utime_us;
    image.id = id;
    image.images = to_message(render_room(robot_.T_base_camera, camera_, utime_us));
    return image;
  }
  void publish_graph(std::int64_t id, std::int64_t utime_us) {
    graph_t graph{};
    graph.utime = utime_us;
    graph.n_parts = 1;
    graph.n_nodes = 1;
    graph.nodes.resize(1);
    graph.nodes[0].kind = graph_node_t::KEYFRAME;
    graph.nodes[0].id = id;
    graph.nodes[0].utime = utime_us;
    graph.nodes[0].T_map_base = to_message(SE3::Identity(), utime_us);
    world_.publish("GRAPH", graph);
  }
  void say(const char* verb, std::int64_t utime_us) {
    command_t command{};
    command.utime = utime_us;
    command.verb = verb;
    world_.publish("COMMAND", command);
  }

  RobotModel robot_;
  CameraModel camera_ = small_camera();
  std::shared_ptr<Transport> transport_ = std::make_shared<Transport>("memq://");
  Bus bus_{test_bus("dense_mapper"), transport_};
  Bus world_{test_bus("world"), transport_};
  DenseMapperProcess process_{bus_};
  Tiles grid_, octomap_, cloud_;
  TileReceiver grid_in_{world_, "GRID_VISUAL", [this](const Tile& t) { grid_[t.key] = t; }};
  TileReceiver octomap_in_{world_, "OCTOMAP", [this](const Tile& t) { octomap_[t.key] = t; }};
  TileReceiver cloud_in_{world_, "CLOUD", [this](const Tile& t) { cloud_[t.key] = t; }};
};

TEST_F(DenseMapperProcessTest, MapsWhateverComesFirst) {
  keyframe_image_t damaged = image(2, 1000);
  damaged.images.images[0].data.resize(10);
  damaged.images.images[0].size = 10;
  world_.publish("KEYFRAME_IMAGE", image(1, 1000));
  say("finish", 2000);
  publish_models();
  world_.publish("KEYFRAME_IMAGE", damaged);
  EXPECT_TRUE(soon([&] { return !bus_.status().last_error.empty(); }));
  EXPECT_TRUE(grid_.empty());
  EXPECT_NE(bus_.status().last_error.find("KEYFRAME_IMAGE 2"), std::string::npos);

  publish_graph(1, 1000);
  EXPECT_TRUE(soon([&] { return !grid_.empty() && !octomap_.empty() && !cloud_.empty(); }));
}

TEST_F(DenseMapperProcessTest, ResetEmptiesTheMapAndTheNextBeginsAtAnyId) {
  const auto see = [&](std::int64_t id, std::int64_t utime_us) {
    world_.publish("KEYFRAME_IMAGE", image(id, utime_us));
    publish_graph(id, utime_us);
  };
  const auto mapped = [&] { return alive(grid_) > 0 && alive(octomap_) > 0 && alive(cloud_) > 0; };
  publish_models();
  see(1, 1'000'000);
  say("finish", 1'500'000);
  ASSERT_TRUE(soon(mapped));
  const auto before = alive(octomap_);
  say("reset", 2'000'000);
  ASSERT_TRUE(soon([&] { return alive(grid_) + alive(octomap_) + alive(cloud_) == 0; }));
  see(2, 1'900'000);  // was under way: of the old map
  see(3, 3'000'000);  // not the first of a submap by its number
  say("finish", 3'500'000);
  ASSERT_TRUE(soon(mapped));
  EXPECT_EQ(alive(octomap_), before);
  EXPECT_TRUE(bus_.status().last_error.empty()) << bus_.status().last_error;
}

// 60 keyframes of a place that it knows come at once: it says that it leaves some out, and nothing
// waits in the end.
TEST_F(DenseMapperProcessTest, LeavesOutKnownPlacesWhenItIsBehind) {
  publish_models();
  keyframe_image_t one = image(1, 1'000'000);
  const auto see = [&](std::int64_t id) {
    one.id = id;
    one.utime = id * 1'000'000;
    world_.publish("KEYFRAME_IMAGE", one);
    publish_graph(id, one.utime);
  };
  const auto says = [&](const std::string& text) {
    return bus_.status().state_text.find(text) != std::string::npos;
  };
  for (std::int64_t id = 1; id <= 5; ++id) see(id);  // a submap
  ASSERT_TRUE(soon([&] { return says("5 keyframes mapped, 0 wait"); }));
  EXPECT_FALSE(says("left out"));
  for (std::int64_t id = 6; id <= 65; ++id) see(id);
  for (int i = 0; i < 60'000 && bus_.status().queue < 120; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  ASSERT_EQ(bus_.status().queue, 120);
  EXPECT_TRUE(soon([&] { return says("65 keyframes mapped, 0 wait"); }))
      << bus_.status().state_text;
  EXPECT_TRUE(says("left out")) << bus_.status().state_text;
  EXPECT_TRUE(bus_.status().last_error.empty()) << bus_.status().last_error;
}

}  // namespace
}  // namespace fusion_slam
