#include "libs/calibration/scan_walls.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/SparseCholesky>

#include "libs/calibration/floor.hpp"
#include "libs/scan_matching/surface_normals.hpp"

namespace fusion_slam {
namespace {

constexpr double kAround_us = 1.5e6;
constexpr double kCell_m = 0.10;
constexpr double kCauchy_sigmas = 2.0;
constexpr int kFewestHits = 4;
// A round moves a pose by no more than this; the walls move with them.
constexpr double kStep_m = 0.02;
constexpr double kStep_rad = 0.01;

// Which poses a time lies between, and how far.
struct Between {
  int first = -1;
  double fraction = 0.0;
};
Between between(const std::vector<std::int64_t>& times_us, double utime_us) {
  const auto next =
      std::upper_bound(times_us.begin(), times_us.end(), utime_us,
                       [](double t, std::int64_t u) { return t < static_cast<double>(u); });
  if (next == times_us.begin() || next == times_us.end()) return {};
  const auto before = static_cast<double>(*(next - 1));
  return {static_cast<int>(next - times_us.begin()) - 1,
          (utime_us - before) / (static_cast<double>(*next) - before)};
}

struct System {
  std::vector<Eigen::Triplet<double>> H;
  Eigen::VectorXd g;
};

void add_scan(const LaserScan& scan, const LidarModel& lidar, const PlanarPath& path,
              const SurfaceMap& walls, System* system) {
  Points points;
  std::vector<double> times_us;
  for (const BeamPoint& beam : beam_points(scan, lidar)) {
    if (!path.knows(beam.utime_us)) continue;
    points.push_back(path.at(beam.utime_us) * beam.p);
    times_us.push_back(beam.utime_us);
  }
  if (points.empty()) return;
  const SE2 origin = path.at(times_us.front());
  const Points normals = surface_normals(points, {origin.x, origin.y});
  Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
  int first = -1;
  const auto flush = [&] {
    for (int i = 0; first >= 0 && i < 6; ++i) {
      system->g(3 * first + i) += g(i);
      for (int j = 0; j < 6; ++j) system->H.emplace_back(3 * first + i, 3 * first + j, H(i, j));
    }
    H.setZero();
    g.setZero();
  };
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (normals[k].isZero()) continue;
    const Surface* wall = walls.find(points[k], normals[k]);
    if (wall == nullptr || wall->weight < kFewestHits) continue;
    const Between at = between(path.times_us(), times_us[k]);
    if (at.first < 0) continue;
    if (at.first != first) {
      flush();
      first = at.first;
    }
    const SE2 pose = path.at(times_us[k]);
    const Eigen::Vector2d arm = points[k] - Eigen::Vector2d(pose.x, pose.y);
    const double r = wall->normal.dot(points[k] - wall->point) / lidar.sigma_m;
    const Eigen::Vector3d J =
        Eigen::Vector3d(wall->normal.x(), wall->normal.y(),
                        wall->normal.dot(Eigen::Vector2d(-arm.y(), arm.x()))) /
        lidar.sigma_m;
    Eigen::Matrix<double, 6, 1> both;
    both << (1.0 - at.fraction) * J, at.fraction * J;
    const double weight = 1.0 / (1.0 + r * r / (kCauchy_sigmas * kCauchy_sigmas));
    H += weight * both * both.transpose();
    g += weight * r * both;
  }
  flush();
}

}  // namespace

std::vector<BeamPoint> beam_points(const LaserScan& scan, const LidarModel& lidar) {
  std::vector<BeamPoint> points;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range_m = scan.ranges_m[i];
    if (!(range_m >= lidar.range_min_m && range_m <= lidar.range_max_m)) continue;
    const double angle = scan.rad0 + scan.radstep * static_cast<double>(i);
    points.push_back(
        {static_cast<double>(scan.utime_us) + 1e6 * lidar.beam_period_s * static_cast<double>(i),
         {range_m * std::cos(angle), range_m * std::sin(angle)}});
  }
  return points;
}

SurfaceMap draw_walls(const std::vector<LaserScan>& scans, const LidarModel& lidar,
                      const PlanarPath& path, double begin_us, double end_us, double cell_m) {
  SurfaceMap map(cell_m);
  for (const LaserScan& scan : scans) {
    const auto utime_us = static_cast<double>(scan.utime_us);
    if (utime_us < begin_us || utime_us > end_us || !path.knows(utime_us)) continue;
    Points points;
    for (const BeamPoint& beam : beam_points(scan, lidar))
      if (path.knows(beam.utime_us)) points.push_back(path.at(beam.utime_us) * beam.p);
    const SE2 origin = path.at(utime_us);
    map.add(points, surface_normals(points, {origin.x, origin.y}));
  }
  return map;
}

PlanarPath refine_path(const std::vector<LaserScan>& scans, const LidarModel& lidar,
                       const PlanarPath& start, int rounds) {
  PlanarPath path = start;
  if (path.size() < 2) return path;
  for (int round = 0; round < rounds; ++round) {
    const int n = 3 * static_cast<int>(path.size());
    System system;
    system.g = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < n; ++i) {
      const double step = i % 3 == 2 ? kStep_rad : kStep_m;
      system.H.emplace_back(i, i, 1.0 / (step * step));
    }
    std::map<std::int64_t, SurfaceMap> walls;
    for (const LaserScan& scan : scans) {
      const std::int64_t block = block_of(scan.utime_us);
      auto found = walls.find(block);
      if (found == walls.end()) {
        const auto begin_us = static_cast<double>(block_begin_us(block));
        const auto end_us = static_cast<double>(block_begin_us(block + 1));
        walls.clear();
        found = walls
                    .emplace(block, draw_walls(scans, lidar, path, begin_us - kAround_us,
                                               end_us + kAround_us, kCell_m))
                    .first;
      }
      add_scan(scan, lidar, path, found->second, &system);
    }
    Eigen::SparseMatrix<double> H(n, n);
    H.setFromTriplets(system.H.begin(), system.H.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(H);
    if (solver.info() != Eigen::Success) return path;
    const Eigen::VectorXd step = solver.solve(-system.g);
    PlanarPath next;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const std::int64_t t = path.times_us()[i];
      const SE2 pose = path.at(static_cast<double>(t));
      const auto k = static_cast<Eigen::Index>(3 * i);
      next.add(t, {pose.x + step(k), pose.y + step(k + 1), wrap_angle(pose.yaw + step(k + 2))});
    }
    path = next;
  }
  return path;
}

}  // namespace fusion_slam
