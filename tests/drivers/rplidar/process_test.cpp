// The process on a private bus, with the virtual device; and its options.
#include <CLI/CLI.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bot_core/planar_lidar_t.hpp"
#include "drivers/rplidar/options.hpp"
#include "drivers/rplidar/rplidar_process.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/messages/models.hpp"
#include "tests/drivers/config_folder.hpp"
#include "tests/drivers/device_on_bus.hpp"
#include "tests/drivers/rplidar/rig.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

class RplidarOnBus : public DeviceOnBus<RplidarProcess> {
 protected:
  RplidarOnBus() : DeviceOnBus("rplidar"), rig_("a1", virtual_room(18, 360)) {
    world_.subscribe<bot_core::planar_lidar_t>("LIDAR", Policy::kKeepAll,
                                               [this](const auto& m) { scans_.push_back(m); });
    world_.subscribe<robot_model_t>("ROBOT_MODEL", Policy::kKeepAll,
                                    [this](const auto& m) { models_.push_back(m); });
  }
  ~RplidarOnBus() override { finish(); }  // before its device goes
  void start() {
    RobotModel robot;
    robot.name = "tester";
    robot.has_lidar = true;
    RplidarConfig config;
    config.port = rig_.port().string();
    run(robot, config);
  }

  RplidarRig rig_;  // its device; the driver is the process's
  std::vector<bot_core::planar_lidar_t> scans_;
  std::vector<robot_model_t> models_;
};

TEST_F(RplidarOnBus, PublishesTurnsAndTheModelTheyFit) {
  rig_.plug_in();
  start();
  ASSERT_TRUE(soon([&] { return scans_.size() >= 4 && !models_.empty(); }));
  EXPECT_THAT(bus_.status().state_text, HasSubstr("scanning: RPLIDAR A1M8"));
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
  EXPECT_THAT(bus_.status().state_text, HasSubstr("there is no port"));
  EXPECT_THAT(bus_.status().last_error, HasSubstr("there is no port"));
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
  command("rplidar", "reset");
  EXPECT_TRUE(said("restart asked for"));
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

class Options : public testing::Test, protected ConfigFolder {
 protected:
  Options() : ConfigFolder("rplidar-options") {
    write("sensors/my-lidar.yaml",
          "kind: lidar\nbeam_period_s: 0.0005\nport: /dev/mine\nbaud: 256000\nmodel: a2\n"
          "scan_mode: standard\n");
    write("robots/r.yaml", "lidar: my-lidar\nlidar_mount_xyz_m_rpy_deg: [0.1, 0, 0.2, 0, 0, 90]\n");
  }
  static std::string error_of(const std::string& robot) {
    RplidarOptions options;
    options.robot = robot;
    return error_of_setup(options);
  }
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
