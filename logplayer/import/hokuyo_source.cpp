#include "libs/datasets/hokuyo.hpp"
#include "libs/datasets/wheel_odometry.hpp"
#include "logplayer/import/sources.hpp"

namespace fusion_slam {

Timeline hokuyo_source(const ImportOptions& options, RobotConfig* config) {
  const HokuyoLog log = read_mines_hokuyo(options.source);
  Timeline timeline;
  timeline.skipped = log.skipped;
  std::vector<std::int64_t> times;
  SE2 T_odom_base;
  WheelTicks last{log.records[0].scan.utime_us, log.records[0].left_ticks,
                  log.records[0].right_ticks};
  for (const HokuyoRecord& r : log.records) {
    timeline.add_scan(r.scan);
    times.push_back(r.scan.utime_us);
    const WheelTicks now{r.scan.utime_us, r.left_ticks, r.right_ticks};
    T_odom_base = T_odom_base * wheel_motion(kMinesRoverWheels, last, now);
    last = now;
    if (!options.no_odometry)
      timeline.add_pose(EventKind::kOdometry, "ODOMETRY", now.utime_us, to_se3(T_odom_base));
  }
  if (const double rate_hz = median_rate_hz(times); rate_hz > 0.0)
    config->robot.lidar.rate_hz = rate_hz;
  return timeline;
}

}  // namespace fusion_slam
