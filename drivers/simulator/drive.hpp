// A differential-drive robot that follows way points, and what its wheel encoders say. const
// members are thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct DriveLimits {
  double max_speed_m_s = 0.5;
  double max_turn_rad_s = 0.9;
  double max_accel_m_s2 = 0.6;
  double max_turn_accel_rad_s2 = 2.0;
};

class Drive {
 public:
  // From the first way point, looking at the second, round and round through all of them.
  // Throws std::invalid_argument with fewer than two way points.
  Drive(const std::vector<Eigen::Vector2d>& route_m, const DriveLimits& limits, double seconds);

  struct Step {
    SE2 T_world_base;  // at the step's start
    double speed_m_s = 0.0;
    double turn_rad_s = 0.0;  // both constant during the step
  };
  static constexpr double kStepS = 0.001;
  static constexpr double kReachedM = 0.30;  // near enough to a way point to turn to the next

  SE2 T_world_base(double time_s) const;  // exact: an arc within each step
  const std::vector<Step>& steps() const { return steps_; }
  double lap_s() const { return lap_s_; }  // first return to the start; 0: not within the time

 private:
  std::vector<Step> steps_;
  double lap_s_ = 0.0;
};

// At the first way point, looking at the second, standing.
Drive::Step drive_start(const Eigen::Vector2d& first_m, const Eigen::Vector2d& second_m);
// Speeds wished on the way to a point, and the step that is made with what the limits leave of
// them: sets the speeds of `step`, returns the pose at its end.
SE2 drive_step(const Eigen::Vector2d& goal_m, const DriveLimits& limits, Drive::Step* step);

// Motion along an arc: T_start_end.
SE2 arc(double distance_m, double angle_rad);

// Borenstein & Feng 1996: systematic errors (unequal wheels) and random ones (slip, bumps).
struct WheelNoise {
  double wheel_base_m = 0.30;
  double scale_sigma = 0.003;            // of each wheel's radius: constant in a run (tyres, load)
  double slip_sigma_per_sqrt_m = 0.004;  // random walk of each wheel's way
  bool with_scale = true;
  bool with_slip = true;
};

// T_odom_base at the start of every step of the drive, odom being where base was at first.
std::vector<SE2> wheel_odometry(const Drive& drive, const WheelNoise& wheels, std::uint64_t seed,
                                bool noise);

}  // namespace fusion_slam
