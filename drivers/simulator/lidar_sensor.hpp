// A turning 2D LiDAR of the RPLidar A1's class on a moving robot.
#pragma once

#include <cstdint>
#include <functional>

#include "drivers/simulator/scene.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct LidarNoise {
  double range_fraction = 0.01;  // standard deviation by distance: data sheet, "1 % of the range"
  double sure_cosine = 0.17;     // beams flatter than 80 degrees start to get lost ...
  double lost_cosine = 0.05;     // ... and at 87 degrees none comes back
  // The data sheet's 12 m are for a white, facing surface. What comes back goes with reflectance
  // and cosine (Lambert) and with 1 / range^2: others end sooner. Infra-red reflectance is taken
  // for the visible one.
  double white_reflectance = 0.9;
  double fade = 0.3;  // around that range, by so much of the signal, returns become rare
  bool with_noise = true;
  bool with_dropouts = true;
  bool with_sweep = true;  // beams one after the other while the robot moves; else all at once
};

constexpr int kBeams = 360;           // a turn, 1 degree each: data sheet
constexpr double kLidarRateHz = 7.0;  // data sheet: 5.5 typical, 10 at most

// The share of beams that comes back. reflectance 0 to 1, cosine of the angle to the normal.
double return_probability(const LidarNoise& noise, double range_max_m, double range_m,
                          double cosine, double reflectance);

// The sweep that starts at utime_us; beam i is cast from where the robot is at its own time,
// clockwise as the device turns. T_world_base at seconds after utime_us. Lost beams are 0.
// with_noise false: an ideal device, whatever the switches say.
LaserScan sweep(const Scene& scene, const RobotModel& robot, const LidarNoise& noise,
                const std::function<SE2(double)>& T_world_base, std::int64_t utime_us,
                std::uint64_t seed, std::int64_t index, bool with_noise);

}  // namespace fusion_slam
