// A simulated run as an LCM log.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "drivers/simulator/simulation.hpp"

namespace fusion_slam {

struct RecordingSummary {
  std::int64_t n_events = 0;
  std::int64_t n_frames = 0;
  std::int64_t size_bytes = 0;
  double seconds = 0.0;
  double lap_s = 0.0;  // when the route was first completed; 0: not within the time
};

// Writes CAMERA, CAMERA_MODEL, LIDAR, ROBOT_MODEL, ODOMETRY and GROUND_TRUTH (T_world_base with
// each camera frame), in order of utime; log times are utimes. Frames are rendered ahead by
// `threads` threads. Equal simulations give equal bytes, whatever the threads. progress(frames
// done, frames in all). Throws std::runtime_error when the file can't be written; then there is no
// file.
RecordingSummary write_recording(const Simulation& simulation, int threads,
                                 const std::filesystem::path& path,
                                 const std::function<void(std::int64_t, std::int64_t)>& progress);

}  // namespace fusion_slam
