// The first part of real recordings, scans alone: nothing lost, and where the reference is known,
// close to it.
#include "tests/support/recordings.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "libs/datasets/carmen.hpp"
#include "libs/datasets/trajectory_file.hpp"
#include "services/lidar_mapper/lidar_mapper.hpp"

namespace fusion_slam {
namespace {

TEST(Recordings, CsailWithoutOdometryStaysWithItsReference) {
  FS_RECORDING(folder, "lidar/mit-csail-clf");
  const CarmenLog log = read_carmen(folder / "mit-csail.clf");
  const auto reference = read_tum_trajectory(folder / "mit-csail_reference_gmapping_406.tum").poses;
  RobotModel robot;
  robot.has_lidar = true;
  robot.lidar = {0.1, 80.0, 0.03, 5.0, 0.0};
  LidarMapper mapper(robot);
  std::size_t next = 0;
  std::optional<SE2> last_reference, last_estimate;
  int steps = 0;
  double sum_m = 0.0;
  for (std::size_t i = 0; i < 600; ++i) {
    const auto out = mapper.add_scan(log.scans[i].scan);
    ASSERT_TRUE(out.pose);
    while (next < reference.size() && reference[next].utime_us < out.pose->utime_us - 1000) ++next;
    if (next == reference.size() || std::abs(reference[next].utime_us - out.pose->utime_us) > 1000)
      continue;
    const SE2 T = to_se2(reference[next].T_world_reference);
    if (last_reference) {
      const SE2 expected = last_reference->inverse() * T;
      const SE2 got = last_estimate->inverse() * out.pose->T_odom_base;
      sum_m += std::hypot(got.x - expected.x, got.y - expected.y);
      ++steps;
    }
    last_reference = T;
    last_estimate = out.pose->T_odom_base;
  }
  ASSERT_GT(steps, 80);
  EXPECT_LT(sum_m / steps, 0.06);
  EXPECT_EQ(mapper.counts().lost, 0);
}

}  // namespace
}  // namespace fusion_slam
