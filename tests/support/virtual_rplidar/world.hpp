// What a virtual RPLidar sees: turn after turn, from a log or made up.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace fusion_slam {

struct VirtualSample {
  double angle_deg = 0.0;  // clockwise, 0 to 360, as the device reports it
  double range_m = 0.0;    // 0: no return
  int quality = 0;         // 0 to 63
};

struct VirtualTurn {
  std::int64_t utime_us = 0;  // in the log
  std::vector<VirtualSample> samples;
};

struct VirtualWorld {
  std::vector<VirtualTurn> turns;
  double rate_hz = 5.5;  // turns a second, the median of the log's
};

// A room of 4 m by 3 m with a post, n_turns of n_samples that differ: the post goes around.
VirtualWorld virtual_room(int n_turns, int n_samples);

// The LIDAR messages of an LCM log (imported, simulated), or the sweeps of a MAEBot recording with
// the angles that its RPLidar gave. Throws std::runtime_error when there is neither.
VirtualWorld read_virtual_world(const std::filesystem::path& log);

}  // namespace fusion_slam
