// A simulated run as a list of messages: what is due when, and each message's bytes. The log writer
// and the live process both take their messages from here, so they can't differ.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulator/auto_exposure.hpp"
#include "drivers/simulator/hand_held.hpp"
#include "drivers/simulator/route.hpp"
#include "drivers/simulator/sensor_noise.hpp"
#include "drivers/simulator/world.hpp"
#include "libs/camera/image_codec.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct TimeSpan {
  double from_s = 0.0;  // of the run
  double to_s = 0.0;
  bool holds(double time_s) const { return time_s >= from_s && time_s < to_s; }
};

enum class Sensor { kCamera, kLidar, kOdometry };
struct Silence {
  Sensor sensor = Sensor::kLidar;
  TimeSpan span;
};

struct SimulationOptions {
  std::uint64_t seed = 1;
  std::optional<double> seconds;    // else the route's, else 60
  std::optional<double> camera_hz;  // else the route's camera's, else 30
  double lidar_hz = kLidarRateHz;
  SensorNoise noise;
  bool random_route = false;      // safe way points from the seed instead of a given route
  bool hand_held = false;         // the camera alone, carried along the route; no LiDAR, no wheels
  std::vector<TimeSpan> covered;  // the camera's lens is covered: black frames
  std::vector<Silence> silent;    // nothing comes from a sensor
  int threads = 2;                // the bytes do not depend on it
  // For calibration: where the sensors truly are, and by how much the camera's stamps are late;
  // ROBOT_MODEL keeps saying what is on paper.
  std::optional<SE3> T_base_lidar;   // true
  std::optional<SE3> T_base_camera;  // true, optical frame
  double camera_stamps_late_s = 0.0;
};

constexpr std::int64_t kEpochUs = 1'700'000'000'000'000;  // utime of every log's start

// The simulated robot: an Orbbec Astra 0.35 m and an RPLidar A1 0.20 m above the floor.
RobotModel simulated_robot();
CameraModel simulated_camera(double rate_hz);

// In the order in which messages of one moment are written.
enum class Channel { kRobotModel, kCameraModel, kGroundTruth, kOdometry, kLidar, kCamera };
const char* name_of(Channel channel);

struct Due {
  std::int64_t utime_us = 0;  // the message's stamp; the order of a log
  std::int64_t ready_us = 0;  // when a real driver has it: a sweep at its end
  Channel channel = Channel::kRobotModel;
  std::int64_t index = 0;  // 0, 1, 2 ... of its channel
};

// const members are thread-safe.
class Simulation {
 public:
  // `route` instead of the world's own. epoch_us: utime of the start. Throws std::invalid_argument
  // with what to do when there is no route, or no safe one can be found.
  Simulation(const World& world, const std::optional<Route>& route,
             const SimulationOptions& options, std::int64_t epoch_us = kEpochUs);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  // Moves the whole run to another utime of its start; before any message is asked for.
  void start_at(std::int64_t epoch_us);
  // Looks about along the route once, so that no frame later waits for a surface to be painted.
  void practise() const;

  // All messages by stamp. GROUND_TRUTH (T_world_base at the stamp, exact) goes with each frame.
  const std::vector<Due>& schedule() const;
  // Bytes as they go out. Camera frames: each must be asked for, or skipped, once; begun in order,
  // by any number of threads.
  Bytes message(const Due& due) const;
  void skip_frame(const Due& due) const;
  void cancel() const;  // ends all waiting of message(); the bytes are then meaningless

  SE3 T_world_base(double time_s) const;  // exact
  const RobotModel& robot() const;
  const CameraModel& camera() const;
  double seconds() const;
  double lap_s() const;  // when the route was first completed; 0: not within the time
  const std::vector<Eigen::Vector2d>& way_points_m() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fusion_slam
