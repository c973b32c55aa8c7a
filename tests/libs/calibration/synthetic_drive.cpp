#include "tests/libs/calibration/synthetic_drive.hpp"

#include <cmath>
#include <random>

namespace fusion_slam {
namespace {

constexpr std::int64_t kEpoch_us = 1'700'000'000'000'000;
constexpr double kLidarHeight_m = 0.20;

struct Box {  // walls are its sides
  double x0, y0, x1, y1;
};
constexpr Box kRoom{-3.0, -2.5, 3.0, 2.5};
constexpr Box kBoxes[] = {{-2.8, 1.2, -1.9, 2.3}, {1.9, -2.3, 2.7, -1.5}, {1.6, 1.6, 2.4, 2.2}};

// Distance along a ray from p to the nearest side; directions in the plane need not be unit.
double cast(const Eigen::Vector2d& p, const Eigen::Vector2d& d) {
  double nearest = 1e9;
  const auto sides = [&](const Box& b) {
    for (const double x : {b.x0, b.x1}) {
      const double t = (x - p.x()) / d.x();
      const double y = p.y() + t * d.y();
      if (t > 1e-9 && y >= b.y0 && y <= b.y1) nearest = std::min(nearest, t);
    }
    for (const double y : {b.y0, b.y1}) {
      const double t = (y - p.y()) / d.y();
      const double x = p.x() + t * d.x();
      if (t > 1e-9 && x >= b.x0 && x <= b.x1) nearest = std::min(nearest, t);
    }
  };
  sides(kRoom);
  for (const Box& b : kBoxes) sides(b);
  return nearest;
}

std::int64_t us(double time_s) { return kEpoch_us + std::llround(1e6 * time_s); }

LaserScan scan_at(double time_s, const DriveTruth& truth, const LidarModel& lidar,
                  std::mt19937_64* random) {
  std::normal_distribution<double> noise;
  LaserScan scan;
  scan.utime_us = us(time_s);
  scan.rad0 = M_PI;
  scan.radstep = -2.0 * M_PI / 360.0;
  for (int i = 0; i < 360; ++i) {
    const SE2 pose = true_pose(time_s + i * lidar.beam_period_s) * truth.T_base_lidar;
    const double angle = pose.yaw + scan.rad0 + i * scan.radstep;
    scan.ranges_m.push_back(
        static_cast<float>(cast({pose.x, pose.y}, {std::cos(angle), std::sin(angle)}) +
                           truth.range_sigma_m * noise(*random)));
  }
  return scan;
}

DepthFrame frame_at(double time_s, const DriveTruth& truth, const CameraModel& camera,
                    std::mt19937_64* random) {
  std::normal_distribution<double> noise;
  const SE3 T_world_camera = to_se3(true_pose(time_s)) * truth.T_base_camera;
  const Eigen::Vector3d o = T_world_camera.translation();
  DepthFrame frame;
  frame.utime_us = us(time_s - truth.delay_s);
  for (int u = 4; u < camera.width_px; u += 4) {
    frame.columns.emplace_back();
    for (int v = 4; v < camera.height_px; v += 4) {
      const Eigen::Vector3d ray = camera.unproject(u, v, 1.0);
      const Eigen::Vector3d d = T_world_camera.linear() * ray;  // z_m times this
      double z_m = cast(o.head<2>(), d.head<2>());
      if (d.z() < 0.0) z_m = std::min(z_m, -o.z() / d.z());
      z_m += truth.depth_sigmas * camera.depth_sigma(z_m) * noise(*random);
      if (!camera.depth_valid(z_m)) continue;
      frame.columns.back().push_back({static_cast<float>(ray.x()), static_cast<float>(ray.y()),
                                      static_cast<float>(1.0 / z_m)});
    }
  }
  return frame;
}

}  // namespace

DriveTruth::DriveTruth() {
  T_base_camera = from_xyz_rpy(0.13, 0.02, 0.37, 0.02, 0.05, -0.03);
  T_base_camera.linear() *= optical_to_body();
}

SE2 true_pose(double time_s) {
  // Along a curve, always looking ahead: no sideways motion of base.
  const auto at = [](double t) {
    return Eigen::Vector2d(1.4 * std::sin(0.31 * t), 1.0 * std::sin(0.47 * t + 0.5));
  };
  const Eigen::Vector2d p = at(time_s);
  const Eigen::Vector2d ahead = at(time_s + 1e-4) - at(time_s - 1e-4);
  return {p.x(), p.y(), std::atan2(ahead.y(), ahead.x())};
}

CalibrationDrive synthetic_drive(const DriveTruth& truth, double seconds) {
  CalibrationDrive drive;
  std::mt19937_64 random(7);
  RobotModel& robot = drive.robot;
  robot.has_lidar = robot.has_camera = robot.has_odometry = true;
  robot.T_base_lidar.translation().z() = kLidarHeight_m;
  robot.T_base_camera = from_xyz_rpy(0.10, 0, 0.35, 0, 0, 0);
  robot.T_base_camera.linear() *= optical_to_body();
  robot.lidar.beam_period_s = 1.0 / (7.0 * 360.0);
  for (int i = 0; i / 7.0 < seconds; ++i) {
    drive.scans.push_back(scan_at(i / 7.0, truth, robot.lidar, &random));
    drive.lidar.add(us(i / 7.0), true_pose(i / 7.0) * truth.T_base_lidar);
  }
  for (int i = 2; 0.25 * i < seconds - 0.5; ++i)
    drive.frames.push_back(frame_at(0.25 * i, truth, drive.camera, &random));
  SE2 odometry;
  constexpr double kStep_s = 0.02;
  for (int i = 0; kStep_s * i < seconds; ++i) {
    const double t = kStep_s * i;
    drive.odometry.add(us(t - truth.wheel_delay_s), odometry);
    SE2 motion = true_pose(t).inverse() * true_pose(t + kStep_s);
    motion.x /= truth.way_scale;
    motion.y /= truth.way_scale;
    odometry = odometry * motion;
  }
  return drive;
}

}  // namespace fusion_slam
