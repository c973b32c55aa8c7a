// visual_odometry is killed and started again: what it needs it reads from its journal.
#include <filesystem>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "libs/bus/transport.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/visual_odometry/visual_odometry_process.hpp"
#include "tests/services/visual_odometry/rendered_wall.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

BusOptions with_journal(const fs::path& file) {
  BusOptions options = test_bus("visual_odometry");
  options.journal = file;
  return options;
}

// The live process, until it goes out of scope.
struct Running {
  Running(const fs::path& journal, const std::shared_ptr<Transport>& network)
      : bus(with_journal(journal), network), process(bus), thread([this] { bus.run(); }) {}
  ~Running() {
    bus.stop();
    thread.join();
  }
  Bus bus;
  VisualOdometryProcess process;
  std::thread thread;
};

class ProcessResume : public testing::Test {
 protected:
  ProcessResume() {
    camera_.width_px = 320;
    camera_.height_px = 240;
    camera_.fx_px = camera_.fy_px = 262.0;
    camera_.cx_px = 159.5;
    camera_.cy_px = 119.5;
    robot_.T_base_camera = from_xyz_rpy(0.1, 0.0, 0.5, -1.5707963, 0.0, -1.5707963);
    listener_.subscribe<pose_estimate_t>("VISUAL_POSE", Policy::kKeepAll,
                                         [this](const pose_estimate_t& m) { poses_.push_back(m); });
    listener_.subscribe<keyframe_t>("KEYFRAME", Policy::kKeepAll,
                                    [this](const keyframe_t& m) { keyframes_.push_back(m); });
  }
  void SetUp() override { fs::remove(journal_); }
  void TearDown() override { fs::remove(journal_); }

  bool until(const std::function<bool()>& done) {
    for (int i = 0; i < 60'000 && !done(); ++i) listener_.handle(5);
    return done();
  }
  static bool listens(const Bus& bus) { return bus.status().state == status_t::RUNNING; }
  // Sends a frame and waits for its pose.
  void show(int step) {
    const std::size_t before = poses_.size();
    sensors_.publish("CAMERA",
                     to_message(wall_.see(camera_, walk(step), 1'000'000 + step * 33'333)));
    ASSERT_TRUE(until([&] { return poses_.size() > before; })) << step;
  }

  fs::path journal_ =
      fs::path(testing::TempDir()) / ("visual_odometry_journal_" + std::to_string(getpid()));
  std::shared_ptr<Transport> network_ = std::make_shared<Transport>("memq://");
  Bus sensors_{test_bus("sensors", Mode::kThroughput), network_};
  Bus listener_{test_bus("listener", Mode::kThroughput), network_};
  CameraModel camera_;
  RobotModel robot_;
  RenderedWall wall_;
  std::vector<pose_estimate_t> poses_;
  std::vector<keyframe_t> keyframes_;
};

TEST_F(ProcessResume, TheJournalGivesItItsMapItsNumbersAndItsModels) {
  {
    Running first(journal_, network_);
    ASSERT_TRUE(until([&] { return listens(first.bus); }));
    sensors_.publish("CAMERA_MODEL", to_message(camera_, 1));
    sensors_.publish("ROBOT_MODEL", to_message(robot_, 1));
    ASSERT_TRUE(until([&] {
      const auto got = first.bus.processed();
      return got.count("CAMERA_MODEL") > 0 && got.count("ROBOT_MODEL") > 0;
    }));
    for (int step = 0; step < 16; ++step) ASSERT_NO_FATAL_FAILURE(show(step));
    ASSERT_TRUE(until([&] { return keyframes_.size() >= 2; }));
  }
  const std::int64_t last_id = poses_.back().reference_id;
  Running second(journal_, network_);
  ASSERT_TRUE(until([&] { return listens(second.bus); }));
  for (int step = 17; step < 29; ++step) {
    ASSERT_NO_FATAL_FAILURE(show(step));
    ASSERT_NE(poses_.back().state, +pose_estimate_t::LOST) << poses_.back().reason;
    const SE3 T_truth =
        robot_.T_base_camera * walk(0).inverse() * walk(step) * robot_.T_base_camera.inverse();
    const SE3 T_odom_base = *from_message(poses_.back().T_frame_base);
    EXPECT_LT(local(T_truth, T_odom_base).head<3>().norm(), 0.05) << step;
  }
  EXPECT_EQ(poses_.back().state, +pose_estimate_t::OK);
  EXPECT_GT(poses_.back().reference_id, last_id);
  for (const keyframe_t& keyframe : keyframes_) {
    EXPECT_EQ(keyframe.previous_id, keyframe.id - 1);  // one segment, numbers without a gap
  }
}

}  // namespace
}  // namespace fusion_slam
