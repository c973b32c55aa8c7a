#include "libs/config/robot_config.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A configuration directory of its own.
class RobotConfigTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(root_ / "robots");
    fs::create_directories(root_ / "sensors");
    write("sensors/lidar-x.yaml", "kind: lidar\nrange_max_m: 9\n");
    write("sensors/camera-x.yaml", "kind: camera\nfx_px: 500\n");
  }
  void TearDown() override { fs::remove_all(root_); }
  void write(const std::string& file, const std::string& text) {
    std::ofstream(root_ / file) << text;
  }
  RobotConfig load(const std::string& text) {
    write("robots/r.yaml", text);
    return load_robot_config(root_ / "robots/r.yaml");
  }
  std::string error(const std::string& text) {
    try {
      load(text);
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "no error";
  }
  fs::path root_ = fs::temp_directory_path() / ("fs_config_test_" + std::to_string(getpid()));
};

TEST_F(RobotConfigTest, SensorsAndMountings) {
  const RobotConfig c = load(
      "name: n\nlidar: lidar-x\ncamera: camera-x\n"
      "lidar_mount_xyz_m_rpy_deg: [0.1, 0, 0.2, 0, 0, 180]\n"
      "camera_mount_xyz_m_rpy_deg: [0, 0, 1, 0, 90, 0]\n"
      "reference_frame: camera\nplanar: false\nodometry: true\n");
  EXPECT_EQ(c.robot.name, "n");
  EXPECT_TRUE(c.robot.has_lidar && c.robot.has_camera && c.robot.has_odometry && !c.robot.planar);
  EXPECT_EQ(c.robot.lidar.range_max_m, 9.0);
  EXPECT_EQ(c.camera.fx_px, 500.0);
  EXPECT_EQ(c.robot.reference_frame, ReferenceFrame::kCamera);
  // A lidar mounted backwards sees a point in front of itself behind base.
  EXPECT_TRUE((c.robot.T_base_lidar * Eigen::Vector3d(1, 0, 0))
                  .isApprox(Eigen::Vector3d(-0.9, 0, 0.2), 1e-9));
  // A camera pitched by 90 degrees looks down: its depth axis is -z of base.
  EXPECT_TRUE((c.robot.T_base_camera.linear() * Eigen::Vector3d::UnitZ())
                  .isApprox(-Eigen::Vector3d::UnitZ(), 1e-9));
}

TEST_F(RobotConfigTest, ErrorsNameFileLineAndWhatIsValid) {
  EXPECT_THAT(error("lidar: lidar-y\n"),
              HasSubstr("r.yaml:1: 'lidar' is 'lidar-y'; the nearest valid value is 'lidar-x'"));
  EXPECT_THAT(error("lidar: camera-x\n"), HasSubstr("(valid: lidar-x)"));
  EXPECT_THAT(error("lidar: lidar-x\nlidar_mont_xyz_m_rpy_deg: [0,0,0,0,0,0]\n"),
              HasSubstr("r.yaml:2: unknown key 'lidar_mont_xyz_m_rpy_deg'; the nearest valid key "
                        "is 'lidar_mount_xyz_m_rpy_deg'"));
  EXPECT_THAT(error("lidar: lidar-x\nlidar_mount_xyz_m_rpy_deg: [90,0,0,0,0,0]\n"),
              HasSubstr("more than 10 m away"));
  EXPECT_THAT(error("lidar: lidar-x\nmap_resolution_m: 0\n"),
              HasSubstr("r.yaml:2: 'map_resolution_m' is 0"));
  EXPECT_THAT(error("lidar: lidar-x\nfloor_clearance_m: 2\n"),
              HasSubstr("not below robot_height_m"));
  EXPECT_THAT(error("lidar: lidar-x\nreference_frame: laser\n"),
              HasSubstr("nearest valid value is"));
  EXPECT_THAT(error("name: x\n"), HasSubstr("both missing"));
  write("sensors/lidar-x.yaml", "kind: lidar\nrange_mx_m: 9\n");
  EXPECT_THAT(
      error("lidar: lidar-x\n"),
      HasSubstr(
          "lidar-x.yaml:2: unknown key 'range_mx_m'; the nearest valid key is 'range_max_m'"));
}

TEST(ShippedConfig, EveryRobotLoads) {
  const fs::path robots = fs::path(FS_SOURCE_DIR) / "config/robots";
  int n = 0;
  for (const auto& file : fs::directory_iterator(robots)) {
    if (file.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(load_robot_config(file.path())) << file.path();
    ++n;
  }
  EXPECT_GE(n, 5);
}

TEST(ShippedConfig, IsFoundFromTheBuildTree) {
  EXPECT_TRUE(fs::exists(config_directory() / "robots/maebot.yaml"));
  EXPECT_EQ(find_robot("maebot").robot.name,
            find_robot((config_directory() / "robots/maebot.yaml").string()).robot.name);
  EXPECT_THROW(find_robot("no-such-robot"), ConfigError);
}

TEST(ShippedConfig, HandHeldCameraIsBase) {
  const RobotConfig c =
      load_robot_config(fs::path(FS_SOURCE_DIR) / "config/robots/hand-held-kinect.yaml");
  EXPECT_FALSE(c.robot.has_lidar);
  EXPECT_FALSE(c.robot.planar);
  EXPECT_EQ(c.robot.reference_frame, ReferenceFrame::kCamera);
  EXPECT_TRUE(c.robot.T_base_camera.linear().isApprox(optical_to_body(), 1e-12));
  EXPECT_TRUE(c.robot.T_base_camera.translation().isZero());
}

}  // namespace
}  // namespace fusion_slam
