// The process on a private bus, with the virtual device; and its options.
#include <fstream>
#include <functional>

#include <CLI/CLI.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bot_core/planar_lidar_t.hpp"
#include "drivers/rplidar/options.hpp"
#include "drivers/rplidar/rplidar_process.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/transport.hpp"
#include "libs/config/yaml_map.hpp"
#include "libs/messages/models.hpp"
#include "tests/drivers/rplidar/rig.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

class RplidarOnBus : public testing::Test {
 protected:
  RplidarOnBus() : rig_("a1", virtual_room(18, 360)) {
    BusOptions options;
    options.process = "rplidar";
    bus_ = std::make_unique<Bus>(options, transport_);
    options.process = "world";
    options.merge_wait_us = 0;
    world_ = std::make_unique<Bus>(options, transport_);
    world_->subscribe<bot_core::planar_lidar_t>("LIDAR", Policy::kKeepAll,
                                                [this](const auto& m) { scans_.push_back(m); });
    world_->subscribe<robot_model_t>("ROBOT_MODEL", Policy::kKeepAll,
                                     [this](const auto& m) { models_.push_back(m); });
  }
  ~RplidarOnBus() override { finish(); }
  void start() {
    RobotModel robot;
    robot.name = "tester";
    robot.has_lidar = true;
    RplidarConfig config;
    config.port = rig_.port().string();
    process_ = std::make_unique<RplidarProcess>(*bus_, robot, config);
    runner_ = std::thread([this] { bus_->run(); });
  }
  void finish() {
    bus_->stop();
    if (runner_.joinable()) runner_.join();
    process_.reset();
  }
  bool soon(const std::function<bool()>& condition) {
    for (int i = 0; i < 2000 && !condition(); ++i) world_->handle(10);
    return condition();
  }

  RplidarRig rig_;  // its device; the driver is the process's
  std::shared_ptr<Transport> transport_ = std::make_shared<Transport>("memq://");
  std::unique_ptr<Bus> bus_, world_;
  std::unique_ptr<RplidarProcess> process_;
  std::thread runner_;
  std::vector<bot_core::planar_lidar_t> scans_;
  std::vector<robot_model_t> models_;
};

TEST_F(RplidarOnBus, PublishesTurnsAndTheModelTheyFit) {
  rig_.plug_in();
  start();
  ASSERT_TRUE(soon([&] { return scans_.size() >= 4 && !models_.empty(); }));
  EXPECT_THAT(bus_->status().state_text, HasSubstr("scanning: RPLIDAR A1M8"));
  finish();
  EXPECT_EQ(models_[0].name, "tester");
  const double express_s = rig_.device().standard_period_s() / 2.0;
  EXPECT_NEAR(models_[0].lidar_beam_period_s, express_s, 1e-6);
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    const auto& scan = scans_[i];
    EXPECT_NEAR(scan.nranges, 720, 2);
    EXPECT_EQ(scan.nintensities, 0);  // express scans have no quality
    EXPECT_NEAR(scan.radstep * scan.nranges, -2.0 * M_PI, 1e-3);
    EXPECT_NEAR(scan.ranges[0], 2.0, 0.01);  // ahead
    EXPECT_GT(scan.utime, 1'500'000'000'000'000);
    EXPECT_GT(scan.utime, i == 0 ? 0 : scans_[i - 1].utime);
  }
}

TEST_F(RplidarOnBus, WithoutADeviceOthersStillGetTheRobot) {
  start();
  ASSERT_TRUE(soon([&] { return !models_.empty(); }));
  EXPECT_THAT(bus_->status().state_text, HasSubstr("there is no port"));
  EXPECT_THAT(bus_->status().last_error, HasSubstr("there is no port"));
  EXPECT_DOUBLE_EQ(models_[0].lidar_beam_period_s, 0.0);
  // What was announced stays, whatever is plugged in later.
  rig_.plug_in();
  ASSERT_TRUE(soon([&] { return scans_.size() >= 2; }));
  const std::size_t n = models_.size();
  ASSERT_TRUE(soon([&] { return models_.size() > n; }));
  EXPECT_DOUBLE_EQ(models_.back().lidar_beam_period_s, 0.0);
}

TEST_F(RplidarOnBus, CommandResetRebootsTheDevice) {
  rig_.plug_in();
  start();
  ASSERT_TRUE(soon([&] { return !scans_.empty(); }));
  command_t command{};
  command.target = "rplidar";
  command.verb = "reset";
  world_->publish("COMMAND", command);
  EXPECT_TRUE(soon(
      [&] { return bus_->status().last_error.find("restart asked for") != std::string::npos; }));
  const std::size_t n = scans_.size();
  EXPECT_TRUE(soon([&] { return scans_.size() > n + 1; }));
}

TEST(RplidarProcess, RunsLiveOnly) {
  BusOptions options;
  options.process = "rplidar";
  options.mode = Mode::kLockstep;
  Bus bus(options, std::make_shared<Transport>("memq://"));
  EXPECT_THROW(RplidarProcess(bus, RobotModel{}, RplidarConfig{}), std::runtime_error);
}

class Options : public testing::Test {
 protected:
  Options()
      : folder_(std::filesystem::temp_directory_path() /
                ("rplidar-options-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_ / "robots");
    std::filesystem::create_directories(folder_ / "sensors");
    write("sensors/my-lidar.yaml",
          "kind: lidar\nbeam_period_s: 0.0005\nport: /dev/mine\nbaud: 256000\nmodel: a2\n"
          "scan_mode: standard\n");
    write("robots/r.yaml", "lidar: my-lidar\nlidar_mount_xyz_m_rpy_deg: [0.1, 0, 0.2, 0, 0, 90]\n");
  }
  ~Options() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string error_of(const std::string& robot) const {
    RplidarOptions options;
    options.robot = robot;
    try {
      load_setup(options);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  std::filesystem::path folder_;
};

TEST_F(Options, TheCommandLineWinsOverTheFile) {
  RplidarOptions options;
  CLI::App app;
  add_options(app, &options);
  app.parse("--robot " + file("robots/r.yaml"));
  RplidarSetup setup = load_setup(options);
  EXPECT_EQ(setup.config.port, "/dev/mine");
  EXPECT_EQ(setup.config.baud, 256000);
  EXPECT_EQ(setup.config.model, "a2");
  EXPECT_EQ(setup.config.scan_mode, "standard");
  EXPECT_DOUBLE_EQ(setup.robot.T_base_lidar.translation().x(), 0.1);
  app.parse("--robot " + file("robots/r.yaml") +
            " --port /dev/other --baud 115200 --model a1 --scan-mode auto");
  setup = load_setup(options);
  EXPECT_EQ(setup.config.port, "/dev/other");
  EXPECT_EQ(setup.config.baud, 115200);
  EXPECT_EQ(setup.config.model, "a1");
  EXPECT_EQ(setup.config.scan_mode, "auto");
}

TEST_F(Options, MistakesAreNamed) {
  EXPECT_THAT(error_of(file("robots/none.yaml")), HasSubstr("there is no robot"));
  write("sensors/my-lidar.yaml", "kind: lidar\nmodel: a9\n");
  EXPECT_THAT(error_of(file("robots/r.yaml")), HasSubstr("model"));
  write("sensors/my-lidar.yaml", "kind: lidar\nbuad: 1\n");
  EXPECT_THAT(error_of(file("robots/r.yaml")), HasSubstr("baud"));
  write("sensors/cam.yaml", "kind: camera\n");
  write("sensors/my-lidar.yaml", "kind: lidar\n");
  write("robots/r.yaml", "camera: cam\n");
  EXPECT_THAT(error_of(file("robots/r.yaml")), HasSubstr("has no LiDAR"));
}

}  // namespace
}  // namespace fusion_slam
