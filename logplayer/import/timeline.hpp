// All events of a recording in order of time, each turned into a message only when its turn comes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "libs/datasets/text.hpp"
#include "libs/datasets/trajectory_file.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"
#include "logplayer/import/log_output.hpp"

namespace fusion_slam {

// Events of one time go out in this order: what is known about the robot before what depends on it.
enum class EventKind { kGroundTruth, kOdometry, kLidar, kCamera };

struct TimelineEvent {
  std::int64_t utime_us = 0;
  EventKind kind = EventKind::kLidar;
  // Writes the message, or says in its result why it cannot (the event is then skipped and
  // counted).
  std::function<std::string(LogOutput&)> write;
};

struct Timeline {
  std::vector<TimelineEvent> events;
  Skipped skipped;                  // what the reader left out
  std::vector<std::string> notes;   // for people
  std::string place_name = "line";  // what Skipped's places count

  void add_pose(EventKind kind, const std::string& channel, std::int64_t utime_us, const SE3& T);
  void add_scan(const LaserScan& scan);
  // By time, then kind, then order of adding.
  void sort();
  // Leaves out frames (LIDAR, CAMERA) before the start-th and after the max-th, and ODOMETRY and
  // GROUND_TRUTH more than 0.1 s away from the frames that stay. Call after sort().
  void keep_frames(std::int64_t start, std::int64_t max_frames);
};

// Sweeps a second: from the median time between scans; 0 for fewer than two.
double median_rate_hz(const std::vector<std::int64_t>& utimes_us);

}  // namespace fusion_slam
