#include "libs/calibration/walls.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "libs/calibration/blocks.hpp"
#include "libs/calibration/scan_walls.hpp"
#include "libs/scan_matching/surface_normals.hpp"

namespace fusion_slam {
namespace {

constexpr double kMostDepth_m = 4.0;
constexpr double kAround_us = 1.5e6;   // scans before and after a block that draw its walls
constexpr double kMostDelay_s = 0.25;  // clocks further apart are a fault, not an offset
constexpr std::size_t kFewestPoints = 500;
constexpr double kWallSigma_m = 0.01;
constexpr double kCauchy_sigmas = 2.0;
constexpr double kFewestHits = 3;  // of beams, on a piece of wall

struct Slices {
  std::int64_t block = 0;
  double utime_us = 0.0;
  std::vector<SlicePoint> points;
};

// x, y, yaw, delay.
struct Unknowns {
  SE2 T_lidar_camera;
  double delay_s = 0.0;
};

struct Sum {
  BlockEquations<4> equations;
  double robust = 0.0;
  double squares = 0.0;
  double weights = 0.0;
  std::size_t n = 0;
};

// Everything at one value of the unknowns.
void add_slices(const CalibrationDrive& drive, const SurfaceMap& walls, const Slices& slices,
                const Unknowns& at, double wall_sigma_m, Sum* sum) {
  const double t_us = slices.utime_us + 1e6 * at.delay_s;
  if (!drive.lidar.knows(t_us)) return;
  const SE2 T_odom_lidar = drive.lidar.at(t_us);
  const Eigen::Vector3d v = drive.lidar.velocity(t_us);
  const SE2 T_odom_camera = T_odom_lidar * at.T_lidar_camera;
  const Eigen::Rotation2Dd R_lidar(T_odom_lidar.yaw);
  const Eigen::Rotation2Dd R_camera(T_odom_camera.yaw);
  const auto turned = [](const Eigen::Vector2d& a) { return Eigen::Vector2d(-a.y(), a.x()); };
  for (const SlicePoint& s : slices.points) {
    if (s.normal.isZero()) continue;
    const Eigen::Vector2d q = T_odom_camera * s.p;
    const Surface* wall = walls.find(q, R_camera * s.normal);
    if (wall == nullptr || wall->weight < kFewestHits) continue;
    const Eigen::Vector2d& n = wall->normal;
    const double along = std::abs(s.normal.dot(s.p.normalized()));
    const double sigma_m = std::hypot(wall_sigma_m, along * s.sigma_m);
    const double r = n.dot(q - wall->point) / sigma_m;
    const double weight = 1.0 / (1.0 + r * r / (kCauchy_sigmas * kCauchy_sigmas));
    // q = T_odom_lidar(t + delay) * (x, y, yaw) * p
    const Eigen::Vector2d lever = q - Eigen::Vector2d(T_odom_lidar.x, T_odom_lidar.y);
    Eigen::Vector4d J;
    J << n.dot(R_lidar * Eigen::Vector2d::UnitX()), n.dot(R_lidar * Eigen::Vector2d::UnitY()),
        n.dot(turned(R_camera * s.p)), n.dot(v.head<2>() + v.z() * turned(lever));
    sum->equations.add(slices.block, J / sigma_m, r, weight);
    sum->robust += std::log1p(r * r / (kCauchy_sigmas * kCauchy_sigmas));
    sum->squares += weight * r * r * sigma_m * sigma_m;
    sum->weights += weight;
    ++sum->n;
  }
}

class Alignment {
 public:
  Alignment(const CalibrationDrive& drive, const std::vector<Slices>& slices)
      : drive_(drive), slices_(slices) {}

  // Walls of a coarseness; find() reaches one to two cells.
  void draw(double cell_m) {
    walls_.clear();
    std::map<std::int64_t, std::pair<double, double>> spans;
    for (const Slices& s : slices_) {
      auto [it, fresh] = spans.try_emplace(s.block, s.utime_us, s.utime_us);
      it->second.second = s.utime_us;
      static_cast<void>(fresh);
    }
    for (const auto& [block, span] : spans)
      walls_.emplace(block, draw_walls(drive_.scans, drive_.robot.lidar, drive_.lidar,
                                       span.first - kAround_us, span.second + kAround_us, cell_m));
  }
  Sum at(const Unknowns& unknowns, double wall_sigma_m) const {
    Sum sum;
    for (const Slices& s : slices_)
      add_slices(drive_, walls_.at(s.block), s, unknowns, wall_sigma_m, &sum);
    return sum;
  }
  Unknowns refine(Unknowns u, double wall_sigma_m, int rounds) const {
    for (int i = 0; i < rounds; ++i) {
      Sum sum = at(u, wall_sigma_m);
      if (sum.n < kFewestPoints) break;
      const Eigen::Vector4d step = sum.equations.step();
      if (!step.allFinite()) break;
      u.T_lidar_camera.x += std::clamp(step(0), -0.1, 0.1);
      u.T_lidar_camera.y += std::clamp(step(1), -0.1, 0.1);
      u.T_lidar_camera.yaw = wrap_angle(u.T_lidar_camera.yaw + std::clamp(step(2), -0.1, 0.1));
      u.delay_s =
          std::clamp(u.delay_s + std::clamp(step(3), -0.05, 0.05), -kMostDelay_s, kMostDelay_s);
      if (step.cwiseAbs().maxCoeff() < 1e-6) break;
    }
    return u;
  }

 private:
  const CalibrationDrive& drive_;
  const std::vector<Slices>& slices_;
  std::map<std::int64_t, SurfaceMap> walls_;
};

}  // namespace

std::vector<SlicePoint> slice(const DepthFrame& frame, const CameraModel& camera,
                              const FloorView& floor, double height_m, double half_m) {
  const SE3 T_level_camera = floor.T_level_camera();
  std::vector<SlicePoint> points;
  Points seen;
  for (const auto& column : frame.columns) {
    // Of a column's points in the band the mean of inverse depth, unless they are of two things.
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double least = 1e9;
    double most = 0.0;
    int n = 0;
    for (const DepthRay& ray : column) {
      const Eigen::Vector3d p_camera = ray.point_m();
      if (p_camera.z() > kMostDepth_m) continue;
      const Eigen::Vector3d p = T_level_camera * p_camera;
      if (std::abs(p.z() - height_m) > half_m) continue;
      sum += p.head<2>();
      least = std::min(least, p_camera.z());
      most = std::max(most, p_camera.z());
      ++n;
    }
    if (n == 0 || most - least > 0.02 + 6.0 * camera.depth_sigma(most)) continue;
    SlicePoint s;
    s.p = sum / n;
    s.sigma_m = camera.depth_sigma(most) / std::sqrt(std::min(n, 4));
    points.push_back(s);
    seen.push_back(s.p);
  }
  std::reverse(seen.begin(), seen.end());  // counter-clockwise, as beams usually go
  const Points normals = surface_normals(seen, Eigen::Vector2d::Zero());
  for (std::size_t i = 0; i < points.size(); ++i) points[i].normal = normals[points.size() - 1 - i];
  return points;
}

std::optional<CameraAgainstLidar> align_to_walls(const CalibrationDrive& drive,
                                                 const FloorView& floor, const SE2& start) {
  const double height_m = drive.robot.T_base_lidar.translation().z();
  std::vector<Slices> slices;
  for (const DepthFrame& frame : drive.frames) {
    Slices s{block_of(frame.utime_us), static_cast<double>(frame.utime_us),
             slice(frame, drive.camera, floor, height_m)};
    if (!s.points.empty()) slices.push_back(std::move(s));
  }
  Alignment alignment(drive, slices);
  alignment.draw(0.25);
  std::optional<Unknowns> best;
  double least = 0.0;
  for (const double delay_s : {0.0, -0.06, 0.06, -0.12, 0.12}) {
    const Unknowns u = alignment.refine({start, delay_s}, 0.05, 12);
    const Sum sum = alignment.at(u, 0.05);
    if (sum.n < kFewestPoints) continue;
    const double cost = sum.robust / static_cast<double>(sum.n);
    if (!best || cost < least) {
      least = cost;
      best = u;
    }
  }
  if (!best) return std::nullopt;
  alignment.draw(0.10);
  *best = alignment.refine(*best, kWallSigma_m, 20);
  const Sum sum = alignment.at(*best, kWallSigma_m);
  if (sum.n < kFewestPoints) return std::nullopt;
  CameraAgainstLidar found;
  found.T_lidar_camera = best->T_lidar_camera;
  found.delay_s = best->delay_s;
  found.covariance = sum.equations.covariance();
  found.n_points = sum.n;
  found.rms_m = std::sqrt(sum.squares / sum.weights);
  return found;
}

}  // namespace fusion_slam
