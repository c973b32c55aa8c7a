// The process on a private bus: LIDAR_POSE and LIDAR_NODE in, GRAPH and POSE out.
#include "services/pose_graph/pose_graph_process.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "fusion_slam/graph_t.hpp"
#include "libs/bus/transport.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

class PoseGraphOnBus : public ::testing::Test {
 protected:
  PoseGraphOnBus() : transport_(std::make_shared<Transport>("memq://")) {
    bus_ = std::make_unique<Bus>(test_bus("pose_graph", Mode::kThroughput), transport_);
    world_ = std::make_unique<Bus>(test_bus("world", Mode::kThroughput), transport_);
    process_ = std::make_unique<PoseGraphProcess>(*bus_);
    world_->subscribe<graph_t>("GRAPH", Policy::kKeepAll, [this](const graph_t& m) {
      if (m.complete != 0) complete_nodes_[m.part] = m.nodes.size();
      largest_part_ = std::max(largest_part_, m.nodes.size());
      for (const graph_node_t& node : m.nodes)
        T_map_base_[node.id] = *from_message(node.T_map_base);
      last_revision_ = m.revision;
    });
    world_->subscribe<pose_estimate_t>("POSE", Policy::kKeepAll,
                                       [this](const pose_estimate_t& m) { poses_.push_back(m); });
  }
  template <class Condition>
  bool soon(Condition condition) {
    for (int i = 0; i < 1500 && !condition(); ++i) {
      while (bus_->handle(1)) {
      }
      while (world_->handle(1)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return condition();
  }
  void drive(int nodes) {
    for (int id = 1; id <= nodes; ++id) {
      const std::int64_t utime_us = id * 100'000;
      pose_estimate_t pose{};
      pose.utime = utime_us;
      pose.state = pose_estimate_t::OK;
      pose.T_frame_base = to_message(from_xyz_rpy(id, 0, 0, 0, 0, 0), utime_us);
      pose.reference_kind = graph_node_t::LIDAR;
      pose.reference_id = id;
      pose.T_reference_base = to_message(SE3::Identity(), utime_us);
      world_->publish("LIDAR_POSE", pose);
      lidar_node_t node{};
      node.utime = utime_us;
      node.id = id;
      node.previous_id = id - 1;
      node.T_odom_base = pose.T_frame_base;
      node.T_previous_base = to_message(from_xyz_rpy(1, 0, 0, 0, 0, 0), utime_us);
      world_->publish("LIDAR_NODE", node);
    }
  }

  std::shared_ptr<Transport> transport_;
  std::unique_ptr<Bus> bus_, world_;
  std::unique_ptr<PoseGraphProcess> process_;
  std::map<int, std::size_t> complete_nodes_;
  std::map<std::int64_t, SE3> T_map_base_;  // as GRAPH said last
  std::size_t largest_part_ = 0;
  std::int64_t last_revision_ = 0;
  std::vector<pose_estimate_t> poses_;
};

TEST_F(PoseGraphOnBus, SaysPosesAndTheWholeGraphInParts) {
  RobotModel robot;
  robot.has_lidar = true;
  world_->publish("ROBOT_MODEL", to_message(robot, 1000));
  drive(900);
  ASSERT_TRUE(soon([this] { return poses_.size() == 900; })) << poses_.size();
  for (const pose_estimate_t& pose : poses_) {
    EXPECT_EQ(pose.frame, "map");
    EXPECT_EQ(pose.state, int{pose_estimate_t::OK});
    EXPECT_NEAR(pose.T_frame_base.trans[0], static_cast<double>(pose.reference_id - 1), 1e-9);
  }
  command_t finish{};
  finish.verb = "finish";
  complete_nodes_.clear();
  world_->publish("COMMAND", finish);
  ASSERT_TRUE(soon([this] { return complete_nodes_.size() == 3; }));
  EXPECT_EQ(complete_nodes_.at(0) + complete_nodes_.at(1) + complete_nodes_.at(2), 900U);
  EXPECT_LE(largest_part_, 400U);
  EXPECT_EQ(last_revision_, 900);
}

TEST_F(PoseGraphOnBus, LevelMovesEveryNodeEvenAfterFinish) {
  RobotModel robot;
  robot.has_lidar = true;
  robot.planar = false;
  world_->publish("ROBOT_MODEL", to_message(robot, 1000));
  drive(5);
  command_t finish{};
  finish.verb = "finish";
  world_->publish("COMMAND", finish);
  ASSERT_TRUE(soon([this] { return !complete_nodes_.empty() && poses_.size() == 5; }));
  constraint_t level{};
  level.utime = 600'000;
  level.from_kind = graph_node_t::MAP;
  level.to_kind = graph_node_t::LIDAR;
  level.to_id = 1;
  level.T_from_to = to_message(from_xyz_rpy(7.0, 8.0, 1.4, 0.0, 0.5, 0.0), 600'000);
  world_->publish("LEVEL", level);
  const SE3 expected = from_xyz_rpy(0.0, 0.0, 1.4, 0.0, 0.5, 0.0);
  ASSERT_TRUE(soon([&] { return T_map_base_[5].translation().z() < -0.5; }));
  for (int id = 1; id <= 5; ++id)
    EXPECT_TRUE(T_map_base_[id].isApprox(expected * from_xyz_rpy(id - 1, 0, 0, 0, 0, 0), 1e-9));
}

TEST_F(PoseGraphOnBus, LevelForAPlanarRobotIsRejected) {
  RobotModel robot;
  robot.has_lidar = true;
  world_->publish("ROBOT_MODEL", to_message(robot, 1000));
  drive(2);
  ASSERT_TRUE(soon([this] { return last_revision_ == 2; }));
  constraint_t level{};
  level.from_kind = graph_node_t::MAP;
  level.to_kind = graph_node_t::LIDAR;
  level.to_id = 1;
  level.T_from_to = to_message(from_xyz_rpy(0, 0, 1.4, 0, 0.5, 0), 1);
  world_->publish("LEVEL", level);
  ASSERT_TRUE(soon([this] { return !bus_->status().last_error.empty(); }));
  EXPECT_NE(bus_->status().last_error.find("planar"), std::string::npos);
  EXPECT_EQ(last_revision_, 2);
}

TEST_F(PoseGraphOnBus, BadInputIsReportedAndDropped) {
  constraint_t constraint{};  // its quaternion is no rotation
  world_->publish("CONSTRAINT", constraint);
  keyframe_t keyframe{};
  keyframe.id = 1;
  world_->publish("KEYFRAME", keyframe);
  ASSERT_TRUE(soon([this] { return !bus_->status().last_error.empty(); }));
  drive(1);
  EXPECT_TRUE(soon([this] { return poses_.size() == 1; }));
}

TEST_F(PoseGraphOnBus, ResetBeginsANewGraphWithWhatIsMeasuredAfterwards) {
  RobotModel robot;
  robot.has_lidar = true;
  world_->publish("ROBOT_MODEL", to_message(robot, 1000));
  drive(9);
  ASSERT_TRUE(soon([this] { return last_revision_ == 9; }));
  command_t reset{};
  reset.utime = 950'000;
  reset.verb = "reset";
  world_->publish("COMMAND", reset);
  ASSERT_TRUE(soon([this] { return last_revision_ == 0; }));
  EXPECT_EQ(complete_nodes_.at(0), 0U);
  T_map_base_.clear();
  const auto node = [&](std::int64_t id, std::int64_t previous_id) {
    lidar_node_t message{};
    message.utime = id * 100'000;
    message.id = id;
    message.previous_id = previous_id;
    message.T_odom_base = to_message(from_xyz_rpy(id, 0, 0, 0, 0, 0), message.utime);
    message.T_previous_base = to_message(from_xyz_rpy(1, 0, 0, 0, 0, 0), message.utime);
    world_->publish("LIDAR_NODE", message);
  };
  constraint_t stale{};
  stale.utime = 900'000;
  world_->publish("CONSTRAINT", stale);  // of the old map: not even looked at
  node(10, 0);
  node(11, 10);
  ASSERT_TRUE(soon([this] { return T_map_base_.count(11) > 0; }));
  EXPECT_EQ(T_map_base_.size(), 2U);
  EXPECT_TRUE(T_map_base_[10].isApprox(SE3::Identity(), 1e-9));
  EXPECT_NEAR(T_map_base_[11].translation().x(), 1.0, 1e-6);
  EXPECT_TRUE(bus_->status().last_error.empty()) << bus_->status().last_error;
}

}  // namespace
}  // namespace fusion_slam
