// The process on a bus in memory: what goes in and what comes out.
#include <algorithm>
#include <chrono>
#include <map>
#include <thread>

#include <gtest/gtest.h>

#include "fusion_slam/lidar_node_t.hpp"
#include "libs/bus/transport.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/lidar_mapper/lidar_mapper_process.hpp"
#include "tests/services/lidar_mapper/flat_world.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

class LidarMapperProcessTest : public ::testing::Test {
 protected:
  LidarMapperProcessTest() {
    listener_.subscribe<pose_estimate_t>("LIDAR_POSE", Policy::kKeepAll,
                                         [this](const auto& m) { poses_.push_back(m); });
    listener_.subscribe<lidar_node_t>("LIDAR_NODE", Policy::kKeepAll,
                                      [this](const auto& m) { nodes_.push_back(m); });
    listener_.subscribe<tile_t>("SUBMAP", Policy::kKeepAll,
                                [this](const auto& m) { tiles_.push_back(m); });
  }

  template <class Condition>
  bool soon(Condition condition) {
    for (int i = 0; i < 1000 && !condition(); ++i) {
      mapper_bus_.handle(2);
      listener_.handle(2);
    }
    return condition();
  }
  void say(const std::string& verb) {
    command_t command{};
    command.utime = 100'000'000;
    command.verb = verb;
    sensor_.publish("COMMAND", command);
  }
  LaserScan scan(int i) {
    return sweep(FlatWorld{}, robot_, test_path, 0.1 * i, 1'000'000 + 100'000 * i, 0.01, rng_);
  }
  void send_scan(int i) { sensor_.publish("LIDAR", to_message(scan(i))); }
  void send_model() { sensor_.publish("ROBOT_MODEL", to_message(robot_, 1'000'000)); }
  void send_odometry(int i) {
    const SE3 T = to_se3(test_path(0.1 * i));
    sensor_.publish("ODOMETRY", to_pose_message(T, 1'000'000 + 100'000 * i));
  }

  RobotModel robot_ = test_robot();
  std::mt19937 rng_{1};
  std::shared_ptr<Transport> transport_ = std::make_shared<Transport>("memq://");
  Bus sensor_{test_bus("sensor"), transport_};
  Bus listener_{test_bus("listener"), transport_};
  Bus mapper_bus_{test_bus("lidar_mapper"), transport_};
  LidarMapperProcess process_{mapper_bus_};
  std::vector<pose_estimate_t> poses_;
  std::vector<lidar_node_t> nodes_;
  std::vector<tile_t> tiles_;
};

TEST_F(LidarMapperProcessTest, ScansWaitForTheModelAndAllArePlaced) {
  for (int i = 0; i < 5; ++i) send_scan(i);
  EXPECT_FALSE(soon([&] { return !poses_.empty() || mapper_bus_.processed()["LIDAR"] == 5; }) &&
               !poses_.empty());
  send_model();
  for (int i = 5; i < 30; ++i) send_scan(i);
  EXPECT_TRUE(soon([&] { return poses_.size() == 30; })) << poses_.size();
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    EXPECT_EQ(poses_[i].utime, 1'000'000 + 100'000 * static_cast<std::int64_t>(i));
    EXPECT_EQ(poses_[i].frame, "odom");
    EXPECT_GE(poses_[i].reference_id, 1);
  }
  ASSERT_FALSE(nodes_.empty());
  EXPECT_EQ(nodes_[0].id, 1);
  EXPECT_EQ(nodes_[0].n_points, static_cast<std::int32_t>(nodes_[0].x_m.size()));
  EXPECT_GT(nodes_[0].n_points, 300);
  const std::size_t before = tiles_.size();
  say("finish");
  EXPECT_TRUE(soon([&] { return tiles_.size() > before; }));
  EXPECT_EQ(tiles_.back().encoding, +tile_t::GRID_PROBABILITY);
}

TEST_F(LidarMapperProcessTest, AScanWaitsForTheOdometryOfItsTimeButNotForever) {
  send_model();
  for (int i = 0; i < 3; ++i) {
    send_odometry(i);
    send_scan(i);
  }
  ASSERT_TRUE(soon([&] { return poses_.size() == 3; }));
  send_scan(3);
  EXPECT_TRUE(soon([&] { return mapper_bus_.processed()["LIDAR"] == 4; }));
  listener_.handle(5);
  EXPECT_EQ(poses_.size(), 3U);
  send_odometry(3);
  EXPECT_TRUE(soon([&] { return poses_.size() == 4; }));
  send_scan(4);
  send_scan(5);  // the odometry has died: the next scan frees the one before
  EXPECT_TRUE(soon([&] { return poses_.size() == 5; }));
  say("finish");
  EXPECT_TRUE(soon([&] { return poses_.size() == 6; }));
}

TEST_F(LidarMapperProcessTest, NonsenseIsReportedAndSurvived) {
  robot_model_t model = to_message(robot_, 1);
  model.map_resolution_m = -1.0;
  sensor_.publish("ROBOT_MODEL", model);
  bot_core::planar_lidar_t bad = to_message(scan(0));
  bad.radstep = 0.0F;
  sensor_.publish("LIDAR", bad);
  EXPECT_TRUE(soon([&] { return mapper_bus_.processed()["LIDAR"] == 1; }));
  EXPECT_FALSE(mapper_bus_.status().last_error.empty());
  send_model();
  send_scan(1);
  EXPECT_TRUE(soon([&] { return poses_.size() == 1; }));
}

TEST_F(LidarMapperProcessTest, AfterResetNoTileOfTheOldMapIsLeft) {
  send_model();
  for (int i = 0; i < 30; ++i) send_scan(i);
  ASSERT_TRUE(soon([&] { return poses_.size() == 30 && !tiles_.empty(); }));
  const std::int64_t last_id = nodes_.back().id;
  command_t reset{};
  reset.utime = 1'000'000 + 100'000 * 29;
  reset.verb = "reset";
  sensor_.publish("COMMAND", reset);
  std::map<TileKey, tile_t> newest;
  ASSERT_TRUE(soon([&] {
    for (const tile_t& tile : tiles_) newest[from_message(tile).key] = tile;
    return std::all_of(newest.begin(), newest.end(),
                       [](const auto& entry) { return entry.second.encoding == tile_t::EMPTY; });
  }));
  const std::size_t before = nodes_.size();
  for (int i = 30; i < 60; ++i) send_scan(i);
  ASSERT_TRUE(soon([&] { return nodes_.size() > before + 1; }));
  EXPECT_EQ(nodes_[before].id, last_id + 1);
  EXPECT_EQ(nodes_[before].previous_id, 0);
}

}  // namespace
}  // namespace fusion_slam
