#include "drivers/simulator/drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "drivers/simulator/random.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint64_t kWheelStream = 20;
constexpr double kSettleS = 0.25;      // time constant with which speeds reach their wishes
constexpr double kSteeringPerS = 1.8;  // turn rate wished per angle error
constexpr double kTurnFirstRad = 0.9;  // look this near at the goal before driving on

double approach(double value, double wish, double limit_per_s) {
  const double rate = std::clamp((wish - value) / kSettleS, -limit_per_s, limit_per_s);
  return value + rate * Drive::kStepS;
}

}  // namespace

SE2 arc(double distance_m, double angle_rad) {
  // Chord of the arc; sin(x)/x by its series near 0.
  const double half = 0.5 * angle_rad;
  const double chord =
      distance_m * (std::fabs(half) < 1e-6 ? 1.0 - half * half / 6.0 : std::sin(half) / half);
  return {chord * std::cos(half), chord * std::sin(half), angle_rad};
}

Drive::Step drive_start(const Eigen::Vector2d& first_m, const Eigen::Vector2d& second_m) {
  const Eigen::Vector2d first = second_m - first_m;
  return {{first_m.x(), first_m.y(), std::atan2(first.y(), first.x())}, 0.0, 0.0};
}

SE2 drive_step(const Eigen::Vector2d& goal_m, const DriveLimits& limits, Drive::Step* step) {
  const SE2& pose = step->T_world_base;
  const Eigen::Vector2d to_goal = goal_m - Eigen::Vector2d(pose.x, pose.y);
  const double error = wrap_angle(std::atan2(to_goal.y(), to_goal.x()) - pose.yaw);
  const double turn =
      std::clamp(kSteeringPerS * error, -limits.max_turn_rad_s, limits.max_turn_rad_s);
  const double speed = limits.max_speed_m_s * std::max(0.0, 1.0 - std::fabs(error) / kTurnFirstRad);
  step->speed_m_s = approach(step->speed_m_s, speed, limits.max_accel_m_s2);
  step->turn_rad_s = approach(step->turn_rad_s, turn, limits.max_turn_accel_rad_s2);
  return pose * arc(step->speed_m_s * Drive::kStepS, step->turn_rad_s * Drive::kStepS);
}

Drive::Drive(const std::vector<Eigen::Vector2d>& route_m, const DriveLimits& limits,
             double seconds) {
  if (route_m.size() < 2) throw std::invalid_argument("a route needs at least two way points");
  Step step = drive_start(route_m[0], route_m[1]);
  std::size_t goal = 1;
  const auto n = static_cast<std::size_t>(std::ceil(seconds / kStepS)) + 1;
  steps_.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const SE2& pose = step.T_world_base;
    if ((route_m[goal] - Eigen::Vector2d(pose.x, pose.y)).norm() < kReachedM) {
      if (goal == 0 && lap_s_ == 0.0) lap_s_ = static_cast<double>(i) * kStepS;
      goal = (goal + 1) % route_m.size();
    }
    const SE2 next = drive_step(route_m[goal], limits, &step);
    steps_.push_back(step);
    step.T_world_base = next;
  }
}

SE2 Drive::T_world_base(double time_s) const {
  const double at = std::clamp(time_s / kStepS, 0.0, static_cast<double>(steps_.size() - 1));
  const Step& step = steps_[static_cast<std::size_t>(at)];
  const double rest_s = (at - std::floor(at)) * kStepS;
  return step.T_world_base * arc(step.speed_m_s * rest_s, step.turn_rad_s * rest_s);
}

std::vector<SE2> wheel_odometry(const Drive& drive, const WheelNoise& wheels, std::uint64_t seed,
                                bool noise) {
  Random random(seed, kWheelStream);
  double scale[2] = {1.0, 1.0};
  for (double& s : scale)
    if (const double g = random.gaussian(); noise && wheels.with_scale) s += wheels.scale_sigma * g;
  std::vector<SE2> poses;
  SE2 pose;
  for (const Drive::Step& step : drive.steps()) {
    poses.push_back(pose);
    double way[2];
    for (int side = 0; side < 2; ++side) {  // left, right
      const double lever = (side == 0 ? -0.5 : 0.5) * wheels.wheel_base_m;
      way[side] = (step.speed_m_s + lever * step.turn_rad_s) * Drive::kStepS * scale[side];
      if (noise && wheels.with_slip)
        way[side] +=
            wheels.slip_sigma_per_sqrt_m * std::sqrt(std::fabs(way[side])) * random.gaussian();
    }
    pose = pose * arc(0.5 * (way[0] + way[1]), (way[1] - way[0]) / wheels.wheel_base_m);
  }
  return poses;
}

}  // namespace fusion_slam
