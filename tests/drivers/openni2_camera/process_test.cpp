// The process on a private bus, with the virtual device; and its options.
#include <CLI/CLI.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/openni2_camera/camera_process.hpp"
#include "drivers/openni2_camera/options.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "tests/drivers/config_folder.hpp"
#include "tests/drivers/device_on_bus.hpp"
#include "tests/drivers/openni2_camera/rig.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

class CameraOnBus : public DeviceOnBus<CameraProcess> {
 protected:
  CameraOnBus() : DeviceOnBus("openni2_camera") {
    world_.subscribe<bot_core::images_t>("CAMERA", Policy::kKeepAll,
                                         [this](const auto& m) { frames_.push_back(m); });
    world_.subscribe<camera_model_t>("CAMERA_MODEL", Policy::kKeepAll,
                                     [this](const auto& m) { models_.push_back(m); });
    world_.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kKeepAll,
                                    [this](const auto&) { ++robots_; });
  }
  ~CameraOnBus() override { finish(); }  // before its device goes
  void start(bool has_lidar) {
    RobotModel robot;
    robot.has_camera = true;
    robot.has_lidar = has_lidar;
    run(robot, rig_.config());
  }

  CameraRig rig_;  // its device; the driver is the process's
  std::vector<bot_core::images_t> frames_;
  std::vector<camera_model_t> models_;
  int robots_ = 0;
};

TEST_F(CameraOnBus, PublishesFramesAndTheModelTheyFit) {
  rig_.plug_in();
  start(true);
  ASSERT_TRUE(soon([&] { return frames_.size() >= 5 && !models_.empty(); }));
  EXPECT_DOUBLE_EQ(models_[0].fx, 140.0);
  EXPECT_EQ(models_[0].width, 160);
  EXPECT_EQ(robots_, 0);  // the LiDAR's driver says it
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    std::string why;
    const auto frame = from_message(frames_[i], &why);
    ASSERT_TRUE(frame) << why;
    EXPECT_EQ(cv::countNonZero(frame->depth_mm != rig_.scene().registered_mm), 0);
    EXPECT_EQ(frames_[i].images[1].utime - frames_[i].images[0].utime, 3000);
    EXPECT_GT(frames_[i].utime, i == 0 ? 0 : frames_[i - 1].utime);
  }
  EXPECT_TRUE(soon([&] {
    return bus_.status().state_text.find("depth to colour 3.0 ms") != std::string::npos;
  }));
}

TEST_F(CameraOnBus, SaysWhyThereAreNoFramesAndWhoseRobotItIs) {
  start(false);
  ASSERT_TRUE(soon([&] { return robots_ > 0; }));
  EXPECT_THAT(bus_.status().state_text, HasSubstr("no frames: no OpenNI2 device"));
  EXPECT_TRUE(frames_.empty());
  rig_.plug_in();
  EXPECT_TRUE(soon([&] { return frames_.size() >= 2; }));
  EXPECT_THAT(bus_.status().state_text, HasSubstr("running:"));
}

TEST_F(CameraOnBus, CommandResetOpensTheDeviceAgain) {
  rig_.plug_in();
  start(true);
  ASSERT_TRUE(soon([&] { return !frames_.empty(); }));
  command("openni2_camera", "reset");
  EXPECT_TRUE(said("restart asked for"));
  const std::size_t n = frames_.size();
  EXPECT_TRUE(soon([&] { return frames_.size() > n + 2; }));
}

TEST(CameraProcessMode, RunsLiveOnly) {
  BusOptions options;
  options.process = "openni2_camera";
  options.mode = Mode::kLockstep;
  Bus bus(options, std::make_shared<Transport>("memq://"));
  EXPECT_THROW(CameraProcess(bus, RobotModel{}, CameraDriverConfig{}), std::runtime_error);
}

class CameraOptionsTest : public testing::Test, protected ConfigFolder {
 protected:
  CameraOptionsTest() : ConfigFolder("openni2-options") {
    write("sensors/cam.yaml",
          "kind: camera\nfx_px: 600\ncolour: /dev/video2\nauto_exposure: false\njpeg_quality: 80\n"
          "depth_fx_px: 580\ndepth_fy_px: 581\ndepth_cx_px: 320\ndepth_cy_px: 240\n"
          "depth_mount_xyz_m_rpy_deg: [0.025, 0, 0, 0, 0, 90]\nstamp_offset_ms: -12\n");
    write("robots/r.yaml", "camera: cam\n");
  }
  static std::string error_of(const std::string& robot) {
    CameraOptions options;
    options.robot = robot;
    return error_of_setup(options);
  }
};

TEST_F(CameraOptionsTest, TheCommandLineWinsOverTheFile) {
  CameraOptions options;
  CLI::App app;
  add_options(app, &options);
  app.parse("--robot " + file("robots/r.yaml"));
  const CameraDriverConfig from_file = load_setup(options).config;
  EXPECT_DOUBLE_EQ(from_file.camera.fx_px, 600.0);
  EXPECT_EQ(from_file.connection.colour, "/dev/video2");
  EXPECT_FALSE(from_file.connection.auto_exposure);
  EXPECT_EQ(from_file.connection.jpeg_quality, 80);
  EXPECT_EQ(from_file.connection.images, "plain");
  EXPECT_DOUBLE_EQ(from_file.connection.depth_fy_px, 581.0);
  EXPECT_DOUBLE_EQ(from_file.connection.stamp_offset_ms, -12.0);
  ASSERT_TRUE(from_file.connection.T_colour_depth);
  EXPECT_DOUBLE_EQ(from_file.connection.T_colour_depth->translation().x(), 0.025);
  write("sensors/other.yaml", "kind: camera\nfx_px: 700\n");
  app.parse("--robot " + file("robots/r.yaml") + " --colour openni2 --auto-exposure on" +
            " --registration own --images packed --jpeg-quality 75 --calibration " +
            file("sensors/other.yaml"));
  const CameraDriverConfig from_line = load_setup(options).config;
  EXPECT_DOUBLE_EQ(from_line.camera.fx_px, 700.0);
  EXPECT_EQ(from_line.connection.colour, "openni2");
  EXPECT_EQ(from_line.connection.registration, "own");
  EXPECT_TRUE(from_line.connection.auto_exposure);
  EXPECT_EQ(from_line.connection.images, "packed");
  EXPECT_EQ(from_line.connection.jpeg_quality, 75);
}

TEST_F(CameraOptionsTest, MistakesAreNamed) {
  EXPECT_THAT(error_of(file("robots/none.yaml")), HasSubstr("there is no robot"));
  write("sensors/cam.yaml", "kind: camera\ncolour: webcam\n");
  EXPECT_THAT(error_of(file("robots/r.yaml")), HasSubstr("neither openni2 nor a device"));
  write("sensors/cam.yaml", "kind: camera\nregistration: hardware\n");
  EXPECT_THAT(error_of(file("robots/r.yaml")), HasSubstr("registration"));
  write("sensors/cam.yaml", "kind: camera\ndepth_fx_px: 580\n");
  EXPECT_THAT(error_of(file("robots/r.yaml")), HasSubstr("depth_fy_px"));
  write("sensors/cam.yaml", "kind: camera\nauto_exposre: true\n");
  EXPECT_THAT(error_of(file("robots/r.yaml")), HasSubstr("auto_exposure"));
}

}  // namespace
}  // namespace fusion_slam
