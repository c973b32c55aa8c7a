#include "libs/datasets/carmen.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

std::string flaser(int n, const std::string& poses, const std::string& time) {
  std::string line = "FLASER " + std::to_string(n);
  for (int i = 0; i < n; ++i) line += " " + std::to_string(1.0 + 0.01 * i);
  return line + " " + poses + " " + time + " host 0.1\n";
}

TEST(Carmen, FlaserGolden) {
  const CarmenLog log = parse_carmen(
      "# a comment\n"
      "PARAM robot_frontlaser_offset 0.12 1.0 host 1.0\n"
      "FLASER 3 1.5 2.5 81.91 1.12 2 0.5 1 2 0.5 1071078718.462310 host 0.25\n"
      "ODOM 7 8 -0.25 0 0 0 1071078718.5 host 0.3\n");
  ASSERT_EQ(log.scans.size(), 1u);
  const CarmenScan& s = log.scans[0];
  EXPECT_EQ(s.line, 3);
  EXPECT_EQ(s.scan.utime_us, 1071078718462310);
  EXPECT_EQ(s.scan.ranges_m, (std::vector<float>{1.5F, 2.5F, 81.91F}));
  EXPECT_EQ(s.laser_pose->x, 1.12);
  EXPECT_EQ(s.odom_pose->x, 1.0);
  EXPECT_EQ(s.odom_pose->yaw, 0.5);
  ASSERT_EQ(log.odometry.size(), 1u);
  EXPECT_EQ(log.odometry[0].pose.yaw, -0.25);
  EXPECT_EQ(log.odometry[0].utime_us, 1071078718500000);
  EXPECT_EQ(log.front_laser_offset_m(), 0.12);
  EXPECT_EQ(log.skipped.total(), 0);
}

TEST(Carmen, AnglesOfTheSickBeamCounts) {
  const auto angles = [](int n) {
    const CarmenLog log = parse_carmen(flaser(n, "0 0 0 0 0 0", "1"));
    const LaserScan& s = log.scans.at(0).scan;
    return std::make_pair(s.rad0 * 180 / M_PI, s.radstep * 180 / M_PI);
  };
  EXPECT_NEAR(angles(181).second, 1.0, 1e-9);
  EXPECT_NEAR(angles(180).second, 1.0, 1e-9);  // the last beam is missing
  EXPECT_NEAR(angles(361).second, 0.5, 1e-9);
  EXPECT_NEAR(angles(360).second, 0.5, 1e-9);
  EXPECT_NEAR(angles(401).second, 0.25, 1e-9);
  EXPECT_NEAR(angles(401).first, -50.0, 1e-9);
  EXPECT_NEAR(angles(360).first, -90.0, 1e-9);
}

TEST(Carmen, RobotLaserGoldenWinsOverRawAndFlaser) {
  const std::string body = " 0 -1.5 3.0 0.75 80 0.01 0 3 1 2 3 3 10 20 30";
  const CarmenLog log =
      parse_carmen("RAWLASER1" + body + " 1.0 host 1.0\n" + flaser(3, "0 0 0 0 0 0", "1.0") +
                   "ROBOTLASER1" + body + " 1.1 2 0 1 2 0 0 0 0.1 0.1 9e9 1.0 host 1.0\n");
  ASSERT_EQ(log.scans.size(), 1u);
  EXPECT_EQ(log.scans[0].line, 3);
  EXPECT_EQ(log.scans[0].scan.rad0, -1.5);
  EXPECT_EQ(log.scans[0].scan.radstep, 0.75);
  EXPECT_EQ(log.scans[0].scan.intensities, (std::vector<float>{10, 20, 30}));
  EXPECT_EQ(log.scans[0].laser_pose->x, 1.1);
  EXPECT_EQ(log.ignored.at("RAWLASER1"), 1);
  EXPECT_EQ(log.ignored.at("FLASER"), 1);
}

TEST(Carmen, RawLaserHasNoPose) {
  const CarmenLog log = parse_carmen("RAWLASER1 0 -1.5 3.0 1.5 80 0.01 0 3 1 2 3 0 1.0 host 1.0\n");
  ASSERT_EQ(log.scans.size(), 1u);
  EXPECT_FALSE(log.scans[0].odom_pose);
  EXPECT_TRUE(log.scans[0].scan.intensities.empty());
}

TEST(Carmen, DamagedLinesAreCountedWithTheirNumber) {
  const CarmenLog log = parse_carmen(flaser(3, "0 0 0 0 0 0", "1.0") +          // 1
                                     "FLASER 3 1 2\n"                           // 2
                                     "FLASER -3 1 2 3\n"                        // 3
                                     "FLASER 99999 1\n"                         // 4
                                     "FLASER 3 1 x 3 0 0 0 0 0 0 2 h 2\n"       // 5
                                     "ODOM 1 2\n"                               // 6
                                     "%$&\x01\n"                                // 7
                                     "FLASER 3 1 2 3 1e99 0 0 0 0 0 3 h 3\n" +  // 8
                                     flaser(3, "0 0 0 0 0 0", "0.5") +          // 9: time goes back
                                     flaser(3, "0 0 0 0 0 0", "4.0") +          // 10
                                     "RLASER 1 1 0 0 0 0 0 0 5 h 5");           // not needed
  EXPECT_EQ(log.lines, 11);
  EXPECT_EQ(log.scans.size(), 2u);
  EXPECT_EQ(log.skipped.total(), 8);
  EXPECT_EQ(log.skipped.reasons().at("FLASER: line ends early").first_place, 2);
  EXPECT_EQ(log.skipped.reasons().at("FLASER: number of readings is not usable").first_place, 3);
  EXPECT_EQ(log.skipped.reasons().at("FLASER: not a number").first_place, 5);
  EXPECT_EQ(log.skipped.reasons().at("not a CARMEN message").first_place, 7);
  EXPECT_EQ(log.skipped.reasons().at("FLASER: pose is not plausible").first_place, 8);
  EXPECT_EQ(log.skipped.reasons().at("scan: time stamp does not increase").first_place, 9);
  EXPECT_EQ(log.ignored.at("RLASER"), 1);
}

TEST(Carmen, CorrectedPosesAreNeverOdometry) {
  const std::string scans =
      flaser(3, "1 2 0.5 1 2 0.5", "1.0") + flaser(3, "2 2 0.5 2 2 0.5", "2.0");
  EXPECT_EQ(parse_carmen(scans).raw_odometry().size(), 2u);
  const CarmenLog corrected = parse_carmen(scans + "NEFF 30\nODOM 1 2 0 0 0 0 1.5 h 1.5\n");
  EXPECT_TRUE(corrected.poses_corrected());
  EXPECT_TRUE(corrected.raw_odometry().empty());
}

TEST(Carmen, OdomLinesServeWhenScansCarryNoOdometry) {
  const CarmenLog log = parse_carmen(flaser(3, "0 0 0 0 0 0", "1") + "ODOM 1 0 0 0 0 0 1.5 h 1\n" +
                                     "ODOM 2 0 0 0 0 0 1.5 h 1\nODOM 3 0 0 0 0 0 1.7 h 1\n" +
                                     flaser(3, "0 0 0 0 0 0", "2"));
  const auto odometry = log.raw_odometry();
  ASSERT_EQ(odometry.size(), 2u);
  EXPECT_EQ(odometry[1].pose.x, 3.0);
}

TEST(Carmen, AnyPrefixOfALogIsFine) {
  const std::string text =
      "PARAM a b 1 h 1\n" + flaser(5, "1 2 3 1 2 3", "1.0") + "ODOM 1 2 3 0 0 0 1 h 1\n";
  for (std::size_t n = 0; n <= text.size(); ++n) EXPECT_NO_THROW(parse_carmen(text.substr(0, n)));
}

TEST(Carmen, ForeignFileIsNamed) {
  const auto path = std::filesystem::path(testing::TempDir()) / "foreign.cpp";
  std::ofstream(path) << "#include <cmath>\nint main() { return 0; }\n";
  try {
    read_carmen(path.string());
    FAIL();
  } catch (const DatasetError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("foreign.cpp: no usable FLASER"));
  }
}

}  // namespace
}  // namespace fusion_slam
