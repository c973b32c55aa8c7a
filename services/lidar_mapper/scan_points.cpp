#include "services/lidar_mapper/scan_points.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "libs/scan_matching/surface_normals.hpp"
#include "services/lidar_mapper/surface_fill.hpp"

namespace fusion_slam {

ScanPoints read_scan(const LaserScan& scan, const RobotModel& robot, const Twist& twist,
                     double max_range_m) {
  const double shortest = std::max(robot.lidar.range_min_m, 1e-3);
  const double longest = std::min(0.999 * robot.lidar.range_max_m, max_range_m);
  const double period_s = std::max(robot.lidar.beam_period_s, 0.0);
  ScanPoints points;
  points.sweep.points.reserve(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range = scan.ranges_m[i];
    if (!(range >= shortest && range <= longest)) {  // nan too
      ++points.n_invalid;
      continue;
    }
    const double angle = scan.rad0 + static_cast<double>(i) * scan.radstep;
    const Eigen::Vector3d p_lidar(range * std::cos(angle), range * std::sin(angle), 0.0);
    points.sweep.points.emplace_back((robot.T_base_lidar * p_lidar).head<2>());
    if (period_s > 0.0) points.sweep.time_s.push_back(static_cast<double>(i) * period_s);
  }
  const Eigen::Vector2d lidar = robot.T_base_lidar.translation().head<2>();
  points.sweep.normals = surface_normals(points.sweep.points, lidar);
  straighten(scan, robot, twist, points);
  return points;
}

ScanPoints points_again(Points hits_base, const RobotModel& robot) {
  ScanPoints points;
  points.origin_base = robot.T_base_lidar.translation().head<2>();
  std::vector<double> steps;
  for (std::size_t i = 1; i < hits_base.size(); ++i) {
    const Eigen::Vector2d a = hits_base[i - 1] - points.origin_base;
    const Eigen::Vector2d b = hits_base[i] - points.origin_base;
    steps.push_back(std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b))));
  }
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                   steps.end());
  const double radstep = steps.empty() ? 0.0 : steps[steps.size() / 2];
  points.sweep.points = hits_base;
  points.sweep.normals = surface_normals(hits_base, points.origin_base);
  points.surface_base = fill_surfaces(hits_base, points.origin_base, radstep,
                                      0.7 * robot.map_resolution_m, robot.lidar.sigma_m);
  points.hits_base = std::move(hits_base);
  return points;
}

void straighten(const LaserScan& scan, const RobotModel& robot, const Twist& twist,
                ScanPoints& points) {
  const SweepPoints& sweep = points.sweep;
  const Eigen::Vector2d lidar = robot.T_base_lidar.translation().head<2>();
  points.hits_base = sweep.points;
  points.origin_base = lidar;
  const bool moves = twist.vx_mps != 0.0 || twist.vy_mps != 0.0 || twist.turn_radps != 0.0;
  if (moves && !sweep.time_s.empty()) {
    for (std::size_t i = 0; i < sweep.points.size(); ++i)
      points.hits_base[i] = twist.motion(sweep.time_s[i]) * sweep.points[i];
    const double half_sweep_s =
        0.5 * static_cast<double>(scan.ranges_m.size()) * robot.lidar.beam_period_s;
    points.origin_base = twist.motion(half_sweep_s) * lidar;
  }
  points.surface_base = fill_surfaces(points.hits_base, points.origin_base, scan.radstep,
                                      0.7 * robot.map_resolution_m, robot.lidar.sigma_m);
}

}  // namespace fusion_slam
