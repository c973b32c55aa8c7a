// LCM event logs of the MAEBot (Univ. of Michigan, EECS 467): an RPLidar A1 on a differential
// drive. Its own types, big-endian:
//   MAEBOT_LASER_SCAN     89dc5b879a5056cf  int64 utime; int32 n; float ranges[n] m; float
//   thetas[n] rad, clockwise;
//                                           int64 times[n] us; float intensities[n]
//   MAEBOT_MOTOR_FEEDBACK 8dc5a028fca42ff9  int64 utime; int32 left, right ticks; ...
//   MAEBOT_POSE           1f317af1246276ac  int64 utime; float x, y (m), theta (rad)
// All utimes are the robot's clock (the log's own time stamps are another machine's).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "libs/datasets/text.hpp"
#include "libs/datasets/wheel_odometry.hpp"
#include "libs/eventlog/event.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

// A revolution as the RPLidar gives it: angles grow clockwise and are uneven.
struct MaebotSweep {
  std::int64_t utime_us = 0;
  std::vector<float> ranges_m;
  std::vector<float> thetas_rad;  // clockwise from forward
  std::vector<std::int64_t> times_us;
  std::vector<float> intensities;
};

struct MaebotPose {
  std::int64_t utime_us = 0;
  SE2 pose;
};

struct MaebotLog {
  std::vector<MaebotSweep> sweeps;  // each list: utime strictly increasing
  std::vector<WheelTicks> encoders;
  std::vector<MaebotPose> poses;
  std::map<std::string, std::int64_t> ignored;  // channel -> events not needed
  std::int64_t events = 0;
  Skipped skipped;  // by byte offset in the file

  // Time from one beam to the next: the median over all sweeps. 0 when there is none.
  double beam_period_s() const;
};

// Adds an event to `log`; false (and counted in log->skipped) when it is damaged. Never throws on
// content.
bool add_maebot_event(const LogEvent& event, MaebotLog* log);
// Throws DatasetError or std::runtime_error when the file cannot be read or holds no sweep. Damaged
// places are skipped and counted.
MaebotLog read_maebot(const std::filesystem::path& path);

// The sweep on an even grid of as many beams, in the order they were measured: rad0 is minus the
// first angle and radstep is -2 pi / n (clockwise), so beam i was measured at utime + i *
// beam_period. Between two neighbours on one surface the range is interpolated, at an edge the
// nearer angle's is taken; 0 (no return) where nothing was measured close by.
LaserScan to_laser_scan(const MaebotSweep& sweep);

}  // namespace fusion_slam
