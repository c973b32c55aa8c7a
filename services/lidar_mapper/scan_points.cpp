#include "services/lidar_mapper/scan_points.hpp"

#include <cmath>

#include "services/lidar_mapper/surface_fill.hpp"

namespace fusion_slam {

SE2 Twist::motion(double dt_s) const {
  const double a = turn_radps * dt_s;
  // Integral of the rotation: (sin a / a, (1 - cos a) / a).
  const double s = std::abs(a) < 1e-6 ? 1.0 - a * a / 6.0 : std::sin(a) / a;
  const double c = std::abs(a) < 1e-6 ? a / 2.0 : (1.0 - std::cos(a)) / a;
  return {(s * vx_mps - c * vy_mps) * dt_s, (c * vx_mps + s * vy_mps) * dt_s, wrap_angle(a)};
}

Twist Twist::from_motion(const SE2& motion, double dt_s) {
  const double a = motion.yaw;
  const double s = std::abs(a) < 1e-6 ? 1.0 - a * a / 6.0 : std::sin(a) / a;
  const double c = std::abs(a) < 1e-6 ? a / 2.0 : (1.0 - std::cos(a)) / a;
  const double det = s * s + c * c;
  return {(s * motion.x + c * motion.y) / det / dt_s, (s * motion.y - c * motion.x) / det / dt_s,
          a / dt_s};
}

ScanPoints read_scan(const LaserScan& scan, const RobotModel& robot, const Twist& twist,
                     double max_range_m) {
  const double shortest = std::max(robot.lidar.range_min_m, 1e-3);
  const double longest = std::min(0.999 * robot.lidar.range_max_m, max_range_m);
  const double period_s = std::max(robot.lidar.beam_period_s, 0.0);
  const bool moves =
      period_s > 0.0 && (twist.vx_mps != 0.0 || twist.vy_mps != 0.0 || twist.turn_radps != 0.0);
  ScanPoints points;
  points.hits_base.reserve(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range = scan.ranges_m[i];
    if (!(range >= shortest && range <= longest)) {  // nan too
      ++points.n_invalid;
      continue;
    }
    const double angle = scan.rad0 + static_cast<double>(i) * scan.radstep;
    const Eigen::Vector3d p_lidar(range * std::cos(angle), range * std::sin(angle), 0.0);
    Eigen::Vector2d p = (robot.T_base_lidar * p_lidar).head<2>();
    if (moves) p = twist.motion(static_cast<double>(i) * period_s) * p;
    points.hits_base.push_back(p);
  }
  const Eigen::Vector2d lidar = robot.T_base_lidar.translation().head<2>();
  const double half_sweep_s = 0.5 * static_cast<double>(scan.ranges_m.size()) * period_s;
  points.origin_base = moves ? Eigen::Vector2d(twist.motion(half_sweep_s) * lidar) : lidar;
  points.surface_base = fill_surfaces(points.hits_base, points.origin_base, scan.radstep,
                                      0.7 * robot.map_resolution_m, robot.lidar.sigma_m);
  return points;
}

}  // namespace fusion_slam
