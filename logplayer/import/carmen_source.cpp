#include <cmath>

#include "libs/datasets/carmen.hpp"
#include "logplayer/import/sources.hpp"

namespace fusion_slam {
namespace {

// T_base_lidar from the two poses of the scans, when they differ by the same motion throughout;
// none when they are equal, are missing or wander (then the laser's pose is a corrected one and
// says nothing about the mounting).
std::optional<SE2> logged_mounting(const CarmenLog& log) {
  std::optional<SE2> mounting;
  for (const CarmenScan& s : log.scans) {
    if (!s.laser_pose || !s.odom_pose) return std::nullopt;
    const SE2 T = s.odom_pose->inverse() * *s.laser_pose;
    if (!mounting) mounting = T;
    const SE2 change = mounting->inverse() * T;
    if (std::hypot(change.x, change.y) > 0.002 || std::abs(change.yaw) > 0.002) return std::nullopt;
  }
  const bool zero =
      mounting && std::hypot(mounting->x, mounting->y) < 0.001 && std::abs(mounting->yaw) < 0.001;
  return zero ? std::nullopt : mounting;
}

void add_odometry(const CarmenLog& log, Timeline* timeline) {
  for (const CarmenOdometry& o : log.raw_odometry())
    timeline->add_pose(EventKind::kOdometry, "ODOMETRY", o.utime_us, to_se3(o.pose));
}

}  // namespace

Timeline carmen_source(const ImportOptions& options, RobotConfig* config) {
  const CarmenLog log = read_carmen(options.source);
  Timeline timeline;
  timeline.skipped = log.skipped;
  if (log.scans.size() < log.skipped.total() / 2.0)
    timeline.notes.push_back(
        "most scans were left out: the log's time stamps were rounded away or never there");
  std::vector<std::int64_t> times;
  for (const CarmenScan& s : log.scans) {
    timeline.add_scan(s.scan);
    times.push_back(s.scan.utime_us);
  }
  if (const double rate_hz = median_rate_hz(times); rate_hz > 0.0)
    config->robot.lidar.rate_hz = rate_hz;
  if (const auto T_base_lidar = logged_mounting(log)) {
    config->robot.T_base_lidar = to_se3(*T_base_lidar);
    timeline.notes.push_back("the log places the laser at x " + std::to_string(T_base_lidar->x) +
                             " m in base; used instead of the robot description's mounting");
  }
  if (log.poses_corrected()) {
    timeline.notes.push_back(
        "the poses in this log were corrected by a SLAM program (NEFF lines): not imported as "
        "ODOMETRY" +
        std::string(options.corrected_as_ground_truth
                        ? "; imported as GROUND_TRUTH as you asked"
                        : "; --corrected-as-ground-truth imports them as GROUND_TRUTH"));
    if (options.corrected_as_ground_truth)
      for (const CarmenScan& s : log.scans)
        if (s.laser_pose)
          timeline.add_pose(EventKind::kGroundTruth, "GROUND_TRUTH", s.scan.utime_us,
                            to_se3(*s.laser_pose) * config->robot.T_base_lidar.inverse() *
                                config->robot.T_base_reference());
  } else if (!options.no_odometry) {
    add_odometry(log, &timeline);
  }
  for (const auto& [keyword, count] : log.ignored)
    timeline.notes.push_back(std::to_string(count) + " " + keyword + " lines are not needed");
  return timeline;
}

}  // namespace fusion_slam
