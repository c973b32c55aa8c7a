#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libs/calibration/blocks.hpp"
#include "libs/calibration/depth_rays.hpp"
#include "libs/calibration/extrinsics.hpp"
#include "libs/calibration/scan_walls.hpp"
#include "tests/libs/calibration/synthetic_drive.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

TEST(PlanarPath, IsExactForConstantAccelerationAtUnevenTimes) {
  PlanarPath path;
  const auto pose = [](double t) {
    return SE2{1.0 + t - 0.3 * t * t, 0.5 * t * t, wrap_angle(3.0 + 0.8 * t + 0.2 * t * t)};
  };
  for (int i = 0; i < 20; ++i) {
    const double t = 0.1 * i + (i % 3) * 0.02;
    path.add(static_cast<std::int64_t>(1e6 * t), pose(t));
  }
  for (int i = 0; i < 100; ++i) {
    const double t = 0.3 + 0.013 * i;
    const SE2 p = path.at(1e6 * t);
    EXPECT_NEAR(p.x, pose(t).x, 1e-9);
    EXPECT_NEAR(p.y, pose(t).y, 1e-9);
    EXPECT_NEAR(wrap_angle(p.yaw - pose(t).yaw), 0.0, 1e-9);
    const SE2 a = path.at(1e6 * t - 10);
    const SE2 b = path.at(1e6 * t + 10);
    const Eigen::Vector3d v = path.velocity(1e6 * t);
    EXPECT_NEAR(v.x(), (b.x - a.x) / 20e-6, 1e-4);
    EXPECT_NEAR(v.z(), wrap_angle(b.yaw - a.yaw) / 20e-6, 1e-4);
  }
}

TEST(PlanarPath, KnowsItsEndsAndGaps) {
  PlanarPath path;
  EXPECT_FALSE(path.knows(0));
  path.add(0, {});
  path.add(100'000, {});
  path.add(100'000, {5, 5, 5});  // ignored
  path.add(2'000'000, {});
  EXPECT_EQ(path.size(), 3U);
  EXPECT_TRUE(path.knows(50'000));
  EXPECT_FALSE(path.knows(1'000'000));
  EXPECT_FALSE(path.knows(-1));
  EXPECT_FALSE(path.knows(2'000'001));
}

// The mean of blocks of equal noise: its variance is what the textbook says.
TEST(BlockEquations, TheJackknifeIsTheSpreadOfTheBlocks) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  BlockEquations<1> equations;
  std::vector<double> means;
  for (int b = 0; b < 40; ++b) {
    const double shared = noise(random);  // an error that a whole block has
    for (int i = 0; i < 10; ++i) equations.add(b, Eigen::Matrix<double, 1, 1>(1.0), -shared, 1.0);
    means.push_back(shared);
  }
  double mean = 0.0;
  double variance = 0.0;
  for (const double m : means) mean += m / 40.0;
  for (const double m : means) variance += (m - mean) * (m - mean) / (39.0 * 40.0);
  EXPECT_NEAR(equations.step()(0), mean, 1e-12);
  EXPECT_NEAR(equations.covariance()(0, 0), variance, 1e-9);
}

TEST(DepthSampler, KeepsSmoothSurfacesOnly) {
  CameraModel camera;
  camera.width_px = 64;
  camera.height_px = 48;
  camera.cx_px = 31.5;
  camera.cy_px = 23.5;
  cv::Mat depth(48, 64, CV_16UC1);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u)
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(u < 32 ? 1000 : 3000);
  depth.at<std::uint16_t>(8, 8) = 0;
  const DepthSampler sampler(camera);
  const DepthFrame frame = sampler.sample(5, depth);
  EXPECT_EQ(frame.utime_us, 5);
  ASSERT_EQ(frame.columns.size(), 14U);
  std::size_t n = 0;
  for (const auto& column : frame.columns)
    for (const DepthRay& ray : column) {
      ++n;
      const double z_m = ray.point_m().z();
      EXPECT_TRUE(std::abs(z_m - 1.0) < 1e-3 || std::abs(z_m - 3.0) < 1e-3);
    }
  EXPECT_EQ(n, 14U * 10U - 10U - 1U);  // the column on the edge, the hole
  EXPECT_TRUE(sampler.sample(5, cv::Mat::zeros(10, 10, CV_16UC1)).columns.empty());
}

TEST(FloorView, IsTheMountingAsThreeNumbers) {
  SE3 T = from_xyz_rpy(0.1, 0.2, 0.4, 0.03, -0.07, 1.0);
  T.linear() *= optical_to_body();
  const FloorView view = floor_view_of(T);
  EXPECT_NEAR(view.height_m, 0.4, 1e-12);
  EXPECT_NEAR(view.roll_rad, 0.03, 1e-12);
  EXPECT_NEAR(view.pitch_rad, -0.07, 1e-12);
  EXPECT_TRUE((to_se3({0.1, 0.2, 1.0}) * view.T_level_camera()).isApprox(T, 1e-12));
}

// The path of a front end is a little off: a centimetre beside its place when the robot turns.
TEST(RefinePath, MendsWhatAFrontEndLeft) {
  DriveTruth truth;
  truth.range_sigma_m = 0.01;
  CalibrationDrive drive = synthetic_drive(truth, 12.0);
  PlanarPath off;
  for (const std::int64_t t : drive.lidar.times_us())
    off.add(t, drive.lidar.at(static_cast<double>(t)) * SE2{0.003, 0.01, 0.0});
  const auto seen = [&](const PlanarPath& path) {
    const auto wheels = find_lidar_on_wheels(path, drive.odometry, SE2{});
    return wheels ? wheels->T_base_lidar : SE2{1, 1, 1};
  };
  EXPECT_NEAR(seen(off).y, truth.T_base_lidar.y + 0.01, 2e-3);
  const SE2 mended = seen(refine_path(drive.scans, drive.robot.lidar, off));
  EXPECT_NEAR(mended.y, truth.T_base_lidar.y, 2e-3);
  EXPECT_NEAR(mended.x, truth.T_base_lidar.x, 2e-3);
}

TEST(Calibration, FindsEverythingInADriveWithoutNoise) {
  const DriveTruth truth;
  const CalibrationDrive drive = synthetic_drive(truth, 25.0);
  const Extrinsics found = calibrate_extrinsics(drive);
  ASSERT_TRUE(found.floor && found.wheels && found.walls);
  const FloorView view = floor_view_of(truth.T_base_camera);
  EXPECT_NEAR(found.floor->height_m, view.height_m, 1e-4);
  EXPECT_NEAR(found.floor->roll_rad, view.roll_rad, 1e-4);
  EXPECT_NEAR(found.floor->pitch_rad, view.pitch_rad, 1e-4);
  EXPECT_NEAR(found.wheels->T_base_lidar.x, truth.T_base_lidar.x, 1e-3);
  EXPECT_NEAR(found.wheels->T_base_lidar.y, truth.T_base_lidar.y, 1e-3);
  EXPECT_NEAR(found.wheels->T_base_lidar.yaw, truth.T_base_lidar.yaw, 1e-3);
  EXPECT_NEAR(found.wheels->way_scale, truth.way_scale, 1e-3);
  EXPECT_NEAR(found.wheels->delay_s, truth.wheel_delay_s, 1e-3);
  EXPECT_NEAR(found.walls->delay_s, truth.delay_s, 1e-3);
  const SE3 error = truth.T_base_camera.inverse() * found.robot.T_base_camera;
  EXPECT_LT(error.translation().norm(), 3e-3);
  EXPECT_LT(log_so3(error.linear()).norm(), 1.5e-3);
  const std::string text = report(found, drive.robot);
  EXPECT_THAT(text, HasSubstr("camera_mount_xyz_m_rpy_deg: ["));
  EXPECT_THAT(text, HasSubstr("stamp_offset_ms: "));
}

TEST(Calibration, NoiseIsAveragedAndSaidToBeThere) {
  DriveTruth truth;
  truth.range_sigma_m = 0.02;
  truth.depth_sigmas = 1.0;
  const CalibrationDrive drive = synthetic_drive(truth, 25.0);
  const Extrinsics found = calibrate_extrinsics(drive);
  ASSERT_TRUE(found.floor && found.wheels && found.walls);
  const SE3 error = truth.T_base_camera.inverse() * found.robot.T_base_camera;
  EXPECT_LT(error.translation().norm(), 0.015);
  EXPECT_LT(log_so3(error.linear()).norm(), 6e-3);
  EXPECT_LT(found.camera_sigma.head<2>().maxCoeff(), 0.01);
  EXPECT_GT(found.camera_sigma.minCoeff(), 1e-5);
}

TEST(Calibration, SaysWhatADriveDoesNotShow) {
  CalibrationDrive drive = synthetic_drive({}, 12.0);
  drive.odometry = {};
  for (DepthFrame& frame : drive.frames) frame.columns.clear();
  const Extrinsics found = calibrate_extrinsics(drive);
  EXPECT_FALSE(found.floor || found.wheels || found.walls);
  EXPECT_TRUE(found.robot.T_base_camera.isApprox(drive.robot.T_base_camera, 1e-9));
  const std::string text = report(found, drive.robot);
  EXPECT_THAT(text, HasSubstr("camera against the floor: not found"));
  EXPECT_THAT(text, HasSubstr("It takes ODOMETRY"));
  EXPECT_THAT(text, HasSubstr("camera against the LiDAR's walls: not found"));
}

}  // namespace
}  // namespace fusion_slam
