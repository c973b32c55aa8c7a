// The log's sensor events, one after the other, through the conductor.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "logplayer/replay/conductor.hpp"
#include "logplayer/run/progress.hpp"

namespace fusion_slam {

struct PlaybackResult {
  std::map<std::string, std::int64_t> played;  // events by channel
  std::int64_t repeats_skipped = 0;
  std::int64_t undecodable_skipped = 0;  // not messages of the channel's type
  std::int64_t first_utime_us = 0;       // log time
  std::int64_t last_utime_us = 0;
  std::int64_t first_sensor_utime_us = 0;  // measurement time of CAMERA and LIDAR
  std::int64_t last_sensor_utime_us = 0;
  std::string damage;  // the log ended early, and why; empty: it was whole
  bool interrupted = false;
};

// The log as a robot without some of its inputs ("camera", "lidar", "odometry") would have written
// it: false, leave this event out. ROBOT_MODEL is told that they aren't there.
bool left_in(const std::set<std::string>& without, LogEvent* event);

// Plays up to most_events (0: all) of what is left in. `on_event` is told of each event played.
// Stops early, without an error, when interrupts() is not 0. Errors of the conductor (a process
// died, no progress) go through; *result then says what was played until then.
void play_log(const std::filesystem::path& log, std::int64_t most_events,
              const std::set<std::string>& without, Conductor& conductor, Progress& progress,
              const std::function<void(const LogEvent&)>& on_event, PlaybackResult* result);

}  // namespace fusion_slam
