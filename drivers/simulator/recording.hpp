// A simulated robot's drive as an LCM log.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "drivers/simulator/camera_noise.hpp"
#include "drivers/simulator/world.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct SimulationOptions {
  std::uint64_t seed = 1;
  double seconds = 60.0;
  double camera_hz = 30.0;
  bool noise = true;
  int threads = 2;  // the bytes do not depend on it
};

constexpr std::int64_t kEpochUs = 1'700'000'000'000'000;  // utime of every recording's start

// The simulated robot: an Orbbec Astra 0.35 m and an RPLidar A1 0.20 m above the floor.
RobotModel simulated_robot();
CameraModel simulated_camera(double rate_hz);

struct RecordingSummary {
  std::int64_t n_events = 0;
  std::int64_t n_frames = 0;
  std::int64_t size_bytes = 0;
  double lap_s = 0.0;  // when the route was first completed; 0: not within the time
};

// Writes CAMERA, CAMERA_MODEL, LIDAR, ROBOT_MODEL, ODOMETRY and GROUND_TRUTH (T_world_base with
// each camera frame), in order of utime; log times are utimes. Equal arguments (threads aside) give
// equal bytes. progress(frames done, frames in all). Throws std::runtime_error when the file can't
// be written; then there is no file.
RecordingSummary write_recording(const World& world, const SimulationOptions& options,
                                 const std::filesystem::path& path,
                                 const std::function<void(std::int64_t, std::int64_t)>& progress);

}  // namespace fusion_slam
