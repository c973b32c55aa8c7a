// An LCM log as a CARMEN log, which gmapping, slam_toolbox's converters and Cartographer's read.
#pragma once

#include "libs/log_export/log_events.hpp"

namespace fusion_slam {

struct CarmenExportOptions {
  bool full_sweep = false;  // ROBOTLASER1 lines with all beams and their angles instead of FLASER
};

// Writes `file`, whole or not at all, lines by time:
//   ODOM x y theta tv rv accel ipc_time host logger_time
//   FLASER n ranges x y theta odom_x odom_y odom_theta ipc_time host logger_time
// FLASER names no angles: readers take 181 (361) readings for -90 to 90 degrees by 1 (0.5) degree,
// counter-clockwise. A sweep with other angles is sampled there, each reading the nearest beam's.
// No return is 81.91, as SICK says it. ipc_time is the middle beam's of those written (CARMEN's
// beams have one time). Poses are ODOMETRY's at that time, 0 when there is none.
// Throws ExportError: there is no LIDAR in the log, or `file` can't be written.
ExportSummary export_carmen(const std::filesystem::path& log, const std::filesystem::path& file,
                            const CarmenExportOptions& options,
                            const std::function<void(double)>& progress = {});

// The readings of a FLASER line and the index of the beam in their middle.
struct FrontHalf {
  std::vector<float> ranges_m;
  double middle_beam = 0.0;
};
FrontHalf front_half(const LaserScan& scan, const LidarModel& lidar);

}  // namespace fusion_slam
