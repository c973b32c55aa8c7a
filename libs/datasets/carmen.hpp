// CARMEN logs (.log, .clf, .gz): 2D laser scans with odometry, one message a line. Formats as the
// header comments of CARMEN's own logs describe them:
//   FLASER n [r]*n x y theta odom_x odom_y odom_theta ipc_time host logger_time
//   RAWLASER1   type start_angle fov resolution max_range accuracy remission_mode n [r]*n m [i]*m
//   ipc_time host logger_time ROBOTLASER1 (the same up to [i]*m) laser_x y theta robot_x y theta tv
//   rv forward side turn ipc_time host logger_time ODOM x y theta tv rv accel ipc_time host
//   logger_time PARAM name value ipc_time host logger_time
// A line that does not fit is skipped and counted, never fatal.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libs/datasets/text.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct CarmenScan {
  std::int64_t line = 0;
  // utime_us is ipc_time: the sensor process's own stamp, and the clock in which benchmark
  // relations are given; it starts near 0 in some logs. logger_time is written after a queue and
  // not used.
  LaserScan scan;
  std::optional<SE2> laser_pose;  // T_odom_lidar as logged (may be a corrected pose)
  std::optional<SE2> odom_pose;   // T_odom_base as logged (raw unless poses_corrected())
};

struct CarmenOdometry {
  std::int64_t line = 0;
  std::int64_t utime_us = 0;
  SE2 pose;
};

struct CarmenLog {
  std::vector<CarmenScan> scans;         // front laser only, utime strictly increasing
  std::vector<CarmenOdometry> odometry;  // ODOM lines, as they come (times may not increase)
  std::map<std::string, std::string>
      params;  // PARAM and "# PARAM"-free lines; the last value counts
  std::map<std::string, std::int64_t> ignored;  // keyword -> lines of kinds that are not needed
  std::int64_t lines = 0;
  std::int64_t neff_lines = 0;  // written by GMapping only
  Skipped skipped;              // by line

  // The poses are a SLAM result (GMapping's gfs2log left its NEFF lines), not odometry. Equal laser
  // and odometry poses do NOT tell: a raw log of a robot whose laser sits in its centre has them
  // equal too (MIT CSAIL).
  bool poses_corrected() const { return neff_lines > 0; }
  // PARAM robot_frontlaser_offset (m, forward), when given.
  std::optional<double> front_laser_offset_m() const;
  // The raw odometry: T_odom_base at strictly increasing times, from the scans' own odometry fields
  // (they are stamped with the scan), or from ODOM lines when the scans carry none that moves.
  // Empty when poses_corrected().
  std::vector<CarmenOdometry> raw_odometry() const;
};

// Never throws on content; `text` may be anything.
CarmenLog parse_carmen(std::string_view text);
// Throws DatasetError when the file cannot be read or holds no usable scan.
CarmenLog read_carmen(const std::filesystem::path& path);

}  // namespace fusion_slam
