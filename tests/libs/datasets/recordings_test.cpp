// The readers on the real recordings; skipped where these are not.
#include "tests/support/recordings.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "libs/datasets/carmen.hpp"
#include "libs/datasets/hokuyo.hpp"
#include "libs/datasets/maebot.hpp"
#include "libs/datasets/rgbd_dataset.hpp"

namespace fusion_slam {
namespace {

// Range by counter-clockwise degree, holes filled from the neighbour.
std::vector<double> profile(const LaserScan& scan) {
  std::vector<double> ranges(360, 0.0);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double degrees = (scan.rad0 + static_cast<double>(i) * scan.radstep) * 180.0 / M_PI;
    ranges[static_cast<std::size_t>(std::lround(degrees) % 360 + 360) % 360] = scan.ranges_m[i];
  }
  for (std::size_t i = 0; i < 720; ++i)
    if (ranges[i % 360] == 0.0) ranges[i % 360] = ranges[(i + 359) % 360];
  return ranges;
}

// The turn of the robot (degrees) that explains b after a best: what was at angle k is at k - turn
// now.
int turn_between(const std::vector<double>& a, const std::vector<double>& b) {
  int best = 0;
  double best_cost = 1e9;
  for (int turn = -50; turn <= 50; ++turn) {
    double cost = 0.0;
    for (int k = 0; k < 360; ++k)
      cost += std::min(0.3, std::abs(a[static_cast<std::size_t>(k)] -
                                     b[static_cast<std::size_t>((k - turn + 360) % 360)]));
    if (cost < best_cost) best = turn;
    best_cost = std::min(cost, best_cost);
  }
  return best;
}

TEST(Recordings, MaebotSweepsTurnTheWayThePosesDo) {
  FS_RECORDING(path, "lidar/lcm-maebot-empty/empty_environment.log");
  const MaebotLog log = read_maebot(path);
  EXPECT_EQ(log.sweeps.size(), 403u);
  EXPECT_EQ(log.poses.size(), 401u);
  EXPECT_EQ(log.encoders.size(), 1506u);
  EXPECT_EQ(log.skipped.total(), 1);  // the first pose
  EXPECT_NEAR(log.beam_period_s(), 0.000505, 0.00001);
  const auto yaw_at = [&](std::int64_t utime_us) {
    for (const MaebotPose& p : log.poses)
      if (p.utime_us == utime_us) return p.pose.yaw;
    return std::nan("");
  };
  int compared = 0;
  for (std::size_t i = 0; i + 4 < log.sweeps.size(); i += 2) {
    const double turned =
        wrap_angle(yaw_at(log.sweeps[i + 4].utime_us) - yaw_at(log.sweeps[i].utime_us)) * 180.0 /
        M_PI;
    if (!(std::abs(turned) > 8.0) || std::abs(turned) > 38.0) continue;
    ++compared;
    const int seen = turn_between(profile(to_laser_scan(log.sweeps[i])),
                                  profile(to_laser_scan(log.sweeps[i + 4])));
    EXPECT_NEAR(seen, turned, 6.0) << "sweep " << i;
  }
  EXPECT_GT(compared, 30);
}

TEST(Recordings, MaebotWheelScaleIsPlausible) {
  FS_RECORDING(path, "lidar/lcm-maebot-empty/empty_environment.log");
  const MaebotLog log = read_maebot(path);
  double path_m = 0.0;
  double wheels_m = 0.0;
  double turned = 0.0;
  for (std::size_t i = 1; i < log.poses.size(); ++i) {
    const SE2 step = log.poses[i - 1].pose.inverse() * log.poses[i].pose;
    path_m += std::hypot(step.x, step.y);
    turned += step.yaw;
  }
  double wheels_turned = 0.0;
  for (std::size_t i = 1; i < log.encoders.size(); ++i) {
    const SE2 step = wheel_motion(kMaebotWheels, log.encoders[i - 1], log.encoders[i]);
    wheels_m += std::hypot(step.x, step.y);
    wheels_turned += step.yaw;
  }
  EXPECT_NEAR(wheels_m / path_m, 1.0, 0.1);
  EXPECT_NEAR(wheels_turned / turned, 1.0, 0.1);
}

TEST(Recordings, Fr079) {
  FS_RECORDING(path, "lidar/fr079/freiburg-079-corrected.log.gz");
  const CarmenLog log = read_carmen(path);
  EXPECT_EQ(log.scans.size(), 4791u);
  EXPECT_EQ(log.scans[0].scan.ranges_m.size(), 360u);
  EXPECT_EQ(log.skipped.total(), 0);
  EXPECT_TRUE(log.poses_corrected());
  EXPECT_TRUE(log.raw_odometry().empty());
}

TEST(Recordings, MitCsail) {
  FS_RECORDING(path, "lidar/mit-csail-clf/mit-csail.clf");
  const CarmenLog log = read_carmen(path);
  EXPECT_EQ(log.scans.size(), 1988u);
  EXPECT_EQ(log.skipped.total(), 0);
  EXPECT_FALSE(log.poses_corrected());
  EXPECT_EQ(log.raw_odometry().size(), 1988u);
  EXPECT_EQ(log.scans[0].scan.utime_us, 1134864629895182);
}

TEST(Recordings, MinesHokuyo) {
  FS_RECORDING(path, "lidar/mines-hokuyo/exp1.dat");
  const HokuyoLog log = read_mines_hokuyo(path);
  EXPECT_EQ(log.records.size(), 756u);
  EXPECT_EQ(log.skipped.total(), 0);
}

TEST(Recordings, SevenScenesRedkitchen) {
  FS_RECORDING(path, "rgbd/7scenes-redkitchen");
  const RgbdDataset d = open_seven_scenes(path);
  EXPECT_EQ(d.entries.size(), 500u);
  EXPECT_EQ(d.reference.size(), 500u);
  std::string why;
  const auto frame = load_frame(d, 250, &why);
  ASSERT_TRUE(frame) << why;
  EXPECT_GT(cv::countNonZero(frame->depth_mm), 640 * 480 / 2);
}

TEST(Recordings, TumDesk) {
  FS_RECORDING(path, "rgbd/tum-fr1-desk-9");
  const RgbdDataset d = open_tum_rgbd(path);
  EXPECT_EQ(d.camera_name, "TUM freiburg1");
  EXPECT_EQ(d.entries.size(), 9u);
  EXPECT_EQ(d.reference.size(), 2335u);
  EXPECT_EQ(d.entries[0].utime_us, 1305031453359684);
  EXPECT_EQ(d.entries[0].depth_utime_us, 1305031453374112);
  std::string why;
  EXPECT_TRUE(load_frame(d, 8, &why)) << why;
}

}  // namespace
}  // namespace fusion_slam
