#include "libs/log_export/carmen_export.hpp"

#include <cmath>

#include "libs/datasets/carmen.hpp"
#include "tests/libs/log_export/export_fixture.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kT0 = 1'700'000'000'000'000;
constexpr double kBeamPeriodS = 0.0004;

// Turns clockwise from behind, as an RPLidar; beam i reads 1 m + i mm, some are lost.
LaserScan rplidar_scan(std::int64_t utime_us) {
  LaserScan scan;
  scan.utime_us = utime_us;
  scan.rad0 = M_PI;
  scan.radstep = -2.0 * M_PI / 360.0;
  for (int i = 0; i < 360; ++i)
    scan.ranges_m.push_back(i % 50 == 7 ? 0.0F : 1.0F + 0.001F * static_cast<float>(i));
  return scan;
}

class CarmenExport : public ExportFixture {
 protected:
  void write_log(const std::vector<LaserScan>& scans) const {
    RobotModel robot;
    robot.has_lidar = robot.has_odometry = true;
    robot.T_base_lidar = from_xyz_rpy(0.2, 0.0, 0.2, 0.0, 0.0, 0.0);
    robot.lidar.beam_period_s = kBeamPeriodS;
    LogWriter log(log_file());
    put(&log, kT0, "ROBOT_MODEL", to_message(robot, kT0));
    for (int i = 0; i < 11; ++i)
      put(&log, kT0 + i * 100'000, "ODOMETRY",
          to_pose_message(to_se3({0.05 * i, 0.0, 0.02 * i}), kT0 + i * 100'000));
    for (const LaserScan& scan : scans) put(&log, scan.utime_us, "LIDAR", to_message(scan));
    log.close();
  }
};

TEST_F(CarmenExport, ImporterReadsBackTheFrontHalf) {
  write_log({rplidar_scan(kT0), rplidar_scan(kT0 + 200'000)});
  const ExportSummary summary = export_carmen(log_file(), folder_ / "out.log", {});
  EXPECT_EQ(summary.written.at("sweeps"), 2);
  const CarmenLog log = read_carmen(folder_ / "out.log");
  EXPECT_EQ(log.skipped.total(), 0);
  EXPECT_FALSE(log.poses_corrected());
  ASSERT_EQ(log.scans.size(), 2U);
  EXPECT_EQ(log.odometry.size(), 11U);
  const CarmenScan& scan = log.scans[1];
  ASSERT_EQ(scan.scan.ranges_m.size(), 181U);
  EXPECT_NEAR(scan.scan.rad0, -0.5 * M_PI, 1e-9);
  // -90 degrees is beam 270, 90 degrees beam 90; the middle one, 180, looks ahead.
  for (std::size_t k = 0; k <= 180; ++k) {
    const std::size_t beam = 270 - k;
    const double expected = beam % 50 == 7 ? 81.91 : 1.0 + 0.001 * static_cast<double>(beam);
    ASSERT_NEAR(scan.scan.ranges_m[k], expected, 6e-4) << k;
  }
  EXPECT_EQ(scan.scan.utime_us, kT0 + 200'000 + 180 * 400);
  const double share = (200'000.0 + 72'000.0) / 100'000.0;
  ASSERT_TRUE(scan.odom_pose && scan.laser_pose);
  EXPECT_NEAR(scan.odom_pose->x, 0.05 * share, 1e-5);
  EXPECT_NEAR(scan.odom_pose->yaw, 0.02 * share, 1e-5);
  const SE2 mounting = scan.odom_pose->inverse() * *scan.laser_pose;
  EXPECT_NEAR(mounting.x, 0.2, 1e-5);
  EXPECT_NEAR(mounting.y, 0.0, 1e-5);
}

TEST_F(CarmenExport, FullSweepKeepsAllBeams) {
  write_log({rplidar_scan(kT0)});
  CarmenExportOptions options;
  options.full_sweep = true;
  export_carmen(log_file(), folder_ / "out.log", options);
  const CarmenLog log = read_carmen(folder_ / "out.log");
  ASSERT_EQ(log.scans.size(), 1U);
  const LaserScan& scan = log.scans[0].scan;
  ASSERT_EQ(scan.ranges_m.size(), 360U);
  EXPECT_NEAR(scan.radstep, 2.0 * M_PI / 360.0, 1e-6);
  const LaserScan sent = rplidar_scan(kT0);
  for (std::size_t i = 0; i < 360; ++i) {
    const std::size_t k = 359 - i;
    const double angle = sent.rad0 + static_cast<double>(i) * sent.radstep;
    ASSERT_NEAR(scan.rad0 + static_cast<double>(k) * scan.radstep, angle, 1e-3);
    const float value = sent.ranges_m[i] > 0.0F ? sent.ranges_m[i] : 81.91F;
    ASSERT_NEAR(scan.ranges_m[k], value, 6e-4);
  }
}

TEST_F(CarmenExport, LinesAreAsTheFormatSays) {
  LaserScan scan;  // a SICK's own angles: written as they are
  scan.utime_us = kT0 + 100'000;
  scan.rad0 = -0.5 * M_PI;
  scan.radstep = M_PI / 180.0;
  scan.ranges_m.assign(181, 2.5F);
  scan.ranges_m[0] = 80.0F;  // beyond the sensor's 12 m
  write_log({scan});
  export_carmen(log_file(), folder_ / "out.log", {});
  std::istringstream lines(text_of(folder_ / "out.log"));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "# CARMEN log of log.lcm by fusion-slam export");
  std::getline(lines, line);
  EXPECT_EQ(line,
            "ODOM 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000 1700000000.000000 "
            "fusion-slam 0.000000");
  std::getline(lines, line);
  EXPECT_EQ(line.substr(0, 55), "ODOM 0.050000 0.000000 0.020000 0.500000 0.200000 0.000") << line;
  std::getline(lines, line);
  EXPECT_EQ(line.substr(0, 23), "FLASER 181 81.910 2.500");
  EXPECT_NE(line.find(" 0.267926 0.005439 0.027200 0.068000 0.000000 0.027200 1700000000.136000"),
            std::string::npos)
      << line;
  EXPECT_NE(line.find(" fusion-slam 0.136000"), std::string::npos) << line;
}

TEST_F(CarmenExport, SaysWhyItCannot) {
  write_log({});
  EXPECT_THROW(export_carmen(log_file(), folder_ / "out.log", {}), ExportError);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.log"));
  EXPECT_THROW(export_carmen(folder_ / "none.lcm", folder_ / "out.log", {}), std::runtime_error);
}

}  // namespace
}  // namespace fusion_slam
