#include "services/visual_odometry/visual_odometry_process.hpp"

#include <gtest/gtest.h>

#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/status_t.hpp"
#include "libs/bus/transport.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "tests/services/visual_odometry/rendered_wall.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

class ProcessOnTheBus : public testing::Test {
 protected:
  ProcessOnTheBus() {
    robot_.T_base_camera = from_xyz_rpy(0.1, 0.0, 0.5, -1.5707963, 0.0, -1.5707963);
    listener_.subscribe<pose_estimate_t>("VISUAL_POSE", Policy::kKeepAll,
                                         [this](const pose_estimate_t& m) { poses_.push_back(m); });
    listener_.subscribe<keyframe_t>("KEYFRAME", Policy::kKeepAll,
                                    [this](const keyframe_t& m) { keyframes_.push_back(m); });
    listener_.subscribe<keyframe_image_t>(
        "KEYFRAME_IMAGE", Policy::kKeepAll,
        [this](const keyframe_image_t& m) { images_.push_back(m); });
  }

  // Lets both buses handle until `done`, at most 5 s.
  template <class Done>
  bool until(Done done) {
    for (int i = 0; i < 500 && !done(); ++i) {
      odometry_bus_.handle(5);
      listener_.handle(5);
    }
    return done();
  }
  bot_core::images_t send_frame(int step) {
    const auto message = to_message(wall_.see(camera_, walk(step), 1'000'000 + step * 33'333));
    sensors_.publish("CAMERA", message);
    return message;
  }
  void send_models() {
    sensors_.publish("CAMERA_MODEL", to_message(camera_, 1));
    sensors_.publish("ROBOT_MODEL", to_message(robot_, 1));
  }

  std::shared_ptr<Transport> transport_ = std::make_shared<Transport>("memq://");
  Bus sensors_{test_bus("sensors", Mode::kThroughput), transport_};
  Bus odometry_bus_{test_bus("visual_odometry", Mode::kThroughput), transport_};
  Bus listener_{test_bus("listener", Mode::kThroughput), transport_};
  VisualOdometryProcess process_{odometry_bus_};
  CameraModel camera_;
  RobotModel robot_;
  RenderedWall wall_;
  std::vector<pose_estimate_t> poses_;
  std::vector<keyframe_t> keyframes_;
  std::vector<keyframe_image_t> images_;
};

TEST_F(ProcessOnTheBus, FramesBecomePosesAndKeyframes) {
  send_models();
  const auto first = send_frame(0);
  ASSERT_TRUE(until([&] { return poses_.size() == 1; }));
  send_frame(1);
  ASSERT_TRUE(until([&] { return poses_.size() == 2 && images_.size() == 1; }));
  EXPECT_EQ(poses_[1].state, +pose_estimate_t::OK);
  EXPECT_EQ(poses_[1].utime, 1'033'333);
  EXPECT_EQ(poses_[1].frame, "odom");
  EXPECT_EQ(poses_[1].reference_kind, +graph_node_t::KEYFRAME);
  EXPECT_EQ(poses_[1].reference_id, 1);
  EXPECT_GT(poses_[1].n_matched, 100);
  ASSERT_EQ(keyframes_.size(), 1U);
  EXPECT_EQ(keyframes_[0].id, 1);
  EXPECT_GT(keyframes_[0].n, 500);
  EXPECT_EQ(keyframes_[0].descriptors.size(), keyframes_[0].n * 32U);
  EXPECT_LT(local(SE3::Identity(), *from_message(keyframes_[0].T_odom_base)).norm(), 1e-9);
  EXPECT_EQ(images_[0].images.images[0].data, first.images[0].data);
}

TEST_F(ProcessOnTheBus, FramesWithoutModelsAndBrokenFramesAreReported) {
  send_frame(0);
  const auto error = [&] { return odometry_bus_.status().last_error; };
  EXPECT_TRUE(until([&] { return error().find("CAMERA_MODEL") != std::string::npos; }));
  send_models();
  auto broken = to_message(wall_.see(camera_, walk(1), 1'033'333));
  broken.images[0].data.resize(10);
  broken.images[0].size = 10;
  sensors_.publish("CAMERA", broken);
  EXPECT_TRUE(until([&] { return error().find("CAMERA refused") != std::string::npos; }));
  send_frame(2);
  EXPECT_TRUE(until([&] { return poses_.size() == 1; }));
}

}  // namespace
}  // namespace fusion_slam
