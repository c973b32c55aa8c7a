#include "libs/datasets/maebot.hpp"
#include "logplayer/import/sources.hpp"

namespace fusion_slam {

Timeline maebot_source(const ImportOptions& options, RobotConfig* config) {
  const MaebotLog log = read_maebot(options.source);
  Timeline timeline;
  timeline.skipped = log.skipped;
  timeline.place_name = "byte";
  std::vector<std::int64_t> times;
  for (const MaebotSweep& sweep : log.sweeps) {
    timeline.add_scan(to_laser_scan(sweep));
    times.push_back(sweep.utime_us);
  }
  if (const double rate_hz = median_rate_hz(times); rate_hz > 0.0)
    config->robot.lidar.rate_hz = rate_hz;
  config->robot.lidar.beam_period_s = log.beam_period_s();
  SE2 T_odom_base;
  for (std::size_t i = 0; i < log.encoders.size() && !options.no_odometry; ++i) {
    if (i > 0)
      T_odom_base = T_odom_base * wheel_motion(kMaebotWheels, log.encoders[i - 1], log.encoders[i]);
    timeline.add_pose(EventKind::kOdometry, "ODOMETRY", log.encoders[i].utime_us,
                      to_se3(T_odom_base));
  }
  for (const MaebotPose& p : log.poses)
    timeline.add_pose(EventKind::kGroundTruth, "GROUND_TRUTH", p.utime_us, to_se3(p.pose));
  if (!log.poses.empty())
    timeline.notes.push_back(
        "GROUND_TRUTH is MAEBOT_POSE: the recording lab's own SLAM, not motion capture");
  for (const auto& [channel, count] : log.ignored)
    timeline.notes.push_back(std::to_string(count) + " " + channel + " events are not needed");
  return timeline;
}

}  // namespace fusion_slam
