#include "services/visual_odometry/lidar_depth.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace fusion_slam {
namespace {

// An upright piece of surface between two neighbouring returns, in the camera's frame.
struct Patch {
  Eigen::Vector3d start;   // the first return
  Eigen::Vector3d along;   // unit, to the second one
  Eigen::Vector3d up;      // unit, the LiDAR's axis
  Eigen::Vector3d normal;  // unit
  double length_m = 0.0;
  double distance_m = 0.0;  // of its plane from the camera, along the normal
};

std::vector<Patch> patches_of(const ScanInBase& scan, const RobotModel& robot,
                              const VisualOdometryConfig& config) {
  const SE3 T_camera_base = robot.T_base_camera.inverse();
  const Eigen::Vector3d up = T_camera_base.linear() * robot.T_base_lidar.linear().col(2);
  const Eigen::Vector3d lidar = T_camera_base * robot.T_base_lidar.translation();
  std::vector<Patch> patches;
  for (std::size_t i = 0; i + 1 < scan.size(); ++i) {
    if (!scan[i].allFinite() || !scan[i + 1].allFinite()) continue;
    Patch patch;
    patch.start = T_camera_base * scan[i];
    const Eigen::Vector3d end = T_camera_base * scan[i + 1];
    if (patch.start.z() <= 0.0 || end.z() <= 0.0) continue;
    patch.along = end - patch.start;
    patch.length_m = patch.along.norm();
    if (patch.length_m < 1e-4) continue;
    patch.along /= patch.length_m;
    patch.up = up;
    patch.normal = patch.along.cross(up).normalized();
    // Seen by the LiDAR at less than config.lidar_min_incidence, two returns may be two surfaces.
    const Eigen::Vector3d beam = (patch.start - lidar).normalized();
    if (std::abs(beam.dot(patch.normal)) < config.lidar_min_incidence) continue;
    patch.distance_m = patch.normal.dot(patch.start);
    patches.push_back(patch);
  }
  return patches;
}

}  // namespace

ScanInBase scan_at(const LaserScan& scan, const RobotModel& robot, const Vector6d& twist_base,
                   std::int64_t frame_utime_us) {
  ScanInBase points;
  points.reserve(scan.ranges_m.size());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range_m = scan.ranges_m[i];
    if (!(range_m >= robot.lidar.range_min_m && range_m <= robot.lidar.range_max_m)) {
      points.emplace_back(nan, nan, nan);
      continue;
    }
    const double angle = scan.rad0 + static_cast<double>(i) * scan.radstep;
    const Eigen::Vector3d p_then =
        robot.T_base_lidar *
        Eigen::Vector3d(range_m * std::cos(angle), range_m * std::sin(angle), 0.0);
    const double dt_s = (frame_utime_us - scan.utime_us) * 1e-6 -
                        static_cast<double>(i) * robot.lidar.beam_period_s;
    // T_then_now = Exp(twist dt); p_now = T_then_now^-1 p_then.
    points.push_back(retract(SE3::Identity(), twist_base * dt_s).inverse() * p_then);
  }
  return points;
}

int attach_lidar_depth(const ScanInBase& scan, const RobotModel& robot, const CameraModel& camera,
                       const VisualOdometryConfig& config, FeatureSet* set) {
  const std::vector<Patch> patches = patches_of(scan, robot, config);
  int n = 0;
  for (Feature& f : set->features) {
    const Eigen::Vector3d ray = camera.unproject(f.u_px, f.v_px, 1.0);
    const double ray_norm = ray.norm();
    const double flattest = config.lidar_min_incidence * ray_norm;
    for (const Patch& patch : patches) {
      const double slope = patch.normal.dot(ray);
      if (std::abs(slope) < flattest) continue;
      const double z_m = patch.distance_m / slope;
      if (z_m <= 0.0) continue;
      const Eigen::Vector3d offset = z_m * ray - patch.start;
      const double t = offset.dot(patch.along);
      if (t < 0.0 || t > patch.length_m) continue;
      const double height_m = std::abs(offset.dot(patch.up));
      const double sigma_m = robot.lidar.sigma_m * ray_norm / std::abs(slope);
      const bool has_depth = f.depth_m > 0.0F;
      const double reach_m = has_depth ? config.lidar_reach_agreed_m : config.lidar_reach_m;
      if (height_m > reach_m) continue;
      if (has_depth) {
        const double both_m = std::hypot(sigma_m, f.depth_sigma_m);
        if (sigma_m >= f.depth_sigma_m || std::abs(z_m - f.depth_m) > 3.0 * both_m) continue;
      }
      f.depth_m = static_cast<float>(z_m);
      f.depth_sigma_m = static_cast<float>(sigma_m);
      ++n;
      break;
    }
  }
  return n;
}

}  // namespace fusion_slam
