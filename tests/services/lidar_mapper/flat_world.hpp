// A small building of straight walls, and a LiDAR in it, for mapper tests. Exact poses, seeded
// noise.
#pragma once

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

struct FlatWorld {
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> walls{
      {{-4, -3}, {6, -3}},       {{6, -3}, {6, 3}},       {{6, 3}, {-4, 3}},
      {{-4, 3}, {-4, -3}},       {{2, 3}, {2, 1}},        {{2, -1}, {2, -3}},
      {{-2, 1}, {-1, 1}},        {{-1, 1}, {-1, 1.8}},    {{4, 0.5}, {4.6, 0.5}},
      {{4.6, 0.5}, {4.6, -0.4}}, {{-4, -1.5}, {-3, -1.5}}};

  double range(const Eigen::Vector2d& from, double heading) const {
    const Eigen::Vector2d d(std::cos(heading), std::sin(heading));
    double nearest = 1e9;
    for (const auto& [a, b] : walls) {
      const Eigen::Vector2d e = b - a, f = a - from;
      const double det = d.x() * -e.y() + d.y() * e.x();
      if (std::abs(det) < 1e-12) continue;
      const double t = (f.x() * -e.y() + f.y() * e.x()) / det;
      const double u = (d.x() * f.y() - d.y() * f.x()) / det;
      if (t > 0.0 && u >= 0.0 && u <= 1.0) nearest = std::min(nearest, t);
    }
    return nearest;
  }
};

inline RobotModel test_robot() {
  RobotModel robot;
  robot.has_lidar = true;
  robot.lidar = {0.1, 12.0, 0.01, 10.0, 0.0};
  robot.T_base_lidar = from_xyz_rpy(0.1, 0.05, 0.3, 0.0, 0.0, 0.4);
  return robot;
}

// A path that turns and drives: pose at time t (s); speed about 0.4 m/s, turns up to 0.5 rad/s.
inline SE2 test_path(double t) {
  return {1.5 * std::sin(0.25 * t) - 1.5, 0.8 * std::sin(0.5 * t) - 0.4, 1.2 * std::sin(0.4 * t)};
}

// One sweep that starts at time t; beams are measured while the robot moves when the model has a
// beam period.
template <class Path>
LaserScan sweep(const FlatWorld& world, const RobotModel& robot, const Path& path, double t,
                std::int64_t utime_us, double noise_m, std::mt19937& rng, int n = 360) {
  std::normal_distribution<double> noise(0.0, 1.0);
  LaserScan scan;
  scan.utime_us = utime_us;
  scan.rad0 = -M_PI;
  scan.radstep = 2.0 * M_PI / n;
  for (int i = 0; i < n; ++i) {
    const SE3 T = to_se3(path(t + i * robot.lidar.beam_period_s)) * robot.T_base_lidar;
    const double angle = scan.rad0 + i * scan.radstep;
    const Eigen::Vector3d d = T.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const double r = world.range(T.translation().head<2>(), std::atan2(d.y(), d.x()));
    scan.ranges_m.push_back(static_cast<float>(r + noise_m * noise(rng)));
  }
  return scan;
}

}  // namespace fusion_slam
