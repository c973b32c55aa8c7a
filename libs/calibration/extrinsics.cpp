#include "libs/calibration/extrinsics.hpp"

#include <cmath>
#include <cstdio>

#include "libs/calibration/scan_walls.hpp"

namespace fusion_slam {
namespace {

constexpr double kDeg = 180.0 / M_PI;
// A number less certain than this is not written into a robot's file.
constexpr double kUseful_m = 0.03;

struct Mount {
  Eigen::Vector3d xyz_m;
  Eigen::Vector3d rpy_rad;
};

Mount mount_of(const SE3& T, bool optical) {
  Eigen::Matrix3d R = T.linear();
  if (optical) R *= optical_to_body().transpose();
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const double pitch = -std::asin(std::max(-1.0, std::min(1.0, R(2, 0))));
  const double roll = std::atan2(R(2, 1), R(2, 2));
  return {T.translation(), {roll, pitch, yaw}};
}

template <class... Values>
std::string line(const char* format, Values... values) {
  char text[300];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string yaml(const char* key, const SE3& T, bool optical) {
  const Mount m = mount_of(T, optical);
  return line("%s: [%.4f, %.4f, %.4f, %.3f, %.3f, %.3f]\n", key, m.xyz_m.x(), m.xyz_m.y(),
              m.xyz_m.z(), m.rpy_rad.x() * kDeg, m.rpy_rad.y() * kDeg, m.rpy_rad.z() * kDeg);
}

std::string row(const char* name, double value, double sigma, double paper, const char* unit) {
  return line("  %-16s %9.4f +- %.4f %-4s (on paper %9.4f)\n", name, value, sigma, unit, paper);
}

}  // namespace

Extrinsics calibrate_extrinsics(const CalibrationDrive& recorded) {
  CalibrationDrive drive = recorded;
  drive.lidar = refine_path(drive.scans, drive.robot.lidar, drive.lidar);
  Extrinsics found;
  found.robot = drive.robot;
  RobotModel& robot = found.robot;
  if (robot.has_camera) found.floor = find_floor(drive.frames, drive.camera, robot.T_base_camera);
  const SE2 lidar_on_paper = to_se2(robot.T_base_lidar);
  if (robot.has_lidar)
    found.wheels = find_lidar_on_wheels(drive.lidar, drive.odometry, lidar_on_paper);
  if (found.wheels &&
      std::sqrt(found.wheels->covariance.diagonal().head<2>().maxCoeff()) > kUseful_m)
    found.wheels.reset();
  // The camera's axis seen from above.
  const Mount camera = mount_of(robot.T_base_camera, true);
  const SE2 camera_on_paper{camera.xyz_m.x(), camera.xyz_m.y(), camera.rpy_rad.z()};
  if (robot.has_camera && robot.has_lidar)
    found.walls = align_to_walls(drive, found.floor.value_or(floor_view_of(robot.T_base_camera)),
                                 lidar_on_paper.inverse() * camera_on_paper);
  const FloorView view = found.floor.value_or(floor_view_of(robot.T_base_camera));
  const SE2 lidar = found.wheels ? found.wheels->T_base_lidar : lidar_on_paper;
  if (found.wheels) {
    SE3 planar_change = to_se3(lidar * lidar_on_paper.inverse());
    robot.T_base_lidar = planar_change * robot.T_base_lidar;
  }
  SE2 at = camera_on_paper;
  if (found.walls) {
    at = lidar * found.walls->T_lidar_camera;
    const Eigen::Rotation2Dd R(lidar.yaw);
    Eigen::Matrix3d C = found.walls->covariance.topLeftCorner<3, 3>();
    Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
    J.topLeftCorner<2, 2>() = R.toRotationMatrix();
    C = J * C * J.transpose();
    if (found.wheels) {
      Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
      K(0, 2) = -(at.y - lidar.y);
      K(1, 2) = at.x - lidar.x;
      C += K * found.wheels->covariance * K.transpose();
    }
    found.camera_sigma = C.diagonal().cwiseMax(0.0).cwiseSqrt();
  }
  if (robot.has_camera) {
    robot.T_base_camera = to_se3(at) * view.T_level_camera();
  }
  return found;
}

std::string report(const Extrinsics& found, const RobotModel& on_paper) {
  std::string text;
  const Mount camera = mount_of(found.robot.T_base_camera, true);
  const Mount camera_paper = mount_of(on_paper.T_base_camera, true);
  if (found.floor) {
    const FloorView& f = *found.floor;
    text += line("camera against the floor, seen in %d frames\n", f.n_frames);
    text += row("height", f.height_m, f.sigma.x(), camera_paper.xyz_m.z(), "m");
    text +=
        row("roll", f.roll_rad * kDeg, f.sigma.y() * kDeg, camera_paper.rpy_rad.x() * kDeg, "deg");
    text += row("pitch", f.pitch_rad * kDeg, f.sigma.z() * kDeg, camera_paper.rpy_rad.y() * kDeg,
                "deg");
  } else if (on_paper.has_camera) {
    text +=
        "camera against the floor: not found. The camera must see floor in many frames, within 15 "
        "degrees and 20 cm of the mounting in ROBOT_MODEL\n";
  }
  if (found.wheels) {
    const LidarOnWheels& w = *found.wheels;
    const SE2 paper = to_se2(on_paper.T_base_lidar);
    const Eigen::Vector3d s = w.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    text += line("LiDAR against the wheels, over %.0f degrees of turning\n", w.turned_rad * kDeg);
    text += row("x", w.T_base_lidar.x, s.x(), paper.x, "m");
    text += row("y", w.T_base_lidar.y, s.y(), paper.y, "m");
    text += row("yaw", w.T_base_lidar.yaw * kDeg, s.z() * kDeg, paper.yaw * kDeg, "deg");
    text += line(
        "  the wheels count %.4f of the way and %.4f of the turns; their stamps are %.1f ms late\n",
        1.0 / w.way_scale, 1.0 / w.turn_scale, -1e3 * w.delay_s);
  } else if (on_paper.has_lidar) {
    text +=
        "LiDAR against the wheels: not found, the mounting on paper is kept. It takes ODOMETRY and "
        "a "
        "drive with at least half a turn each way\n";
  }
  if (found.walls) {
    const CameraAgainstLidar& w = *found.walls;
    text += line("camera against the LiDAR's walls: %zu points, %.1f mm from them (rms)\n",
                 w.n_points, 1e3 * w.rms_m);
    text += row("x", camera.xyz_m.x(), found.camera_sigma.x(), camera_paper.xyz_m.x(), "m");
    text += row("y", camera.xyz_m.y(), found.camera_sigma.y(), camera_paper.xyz_m.y(), "m");
    text += row("yaw", camera.rpy_rad.z() * kDeg, found.camera_sigma.z() * kDeg,
                camera_paper.rpy_rad.z() * kDeg, "deg");
    text +=
        row("time", 1e3 * w.delay_s, 1e3 * std::sqrt(std::max(0.0, w.covariance(3, 3))), 0.0, "ms");
  } else if (on_paper.has_lidar && on_paper.has_camera) {
    text +=
        "camera against the LiDAR's walls: not found. Both must see the same walls: drive along "
        "walls in two directions, nearer than 4 m, with turns\n";
  }
  text += "\nfor the robot's file (config/robots):\n";
  if (found.wheels) text += yaml("lidar_mount_xyz_m_rpy_deg", found.robot.T_base_lidar, false);
  if (found.floor || found.walls)
    text += yaml("camera_mount_xyz_m_rpy_deg", found.robot.T_base_camera, true);
  if (found.walls)
    text += line(
        "for the camera's file (config/sensors), added to what stands there:\nstamp_offset_ms: "
        "%.1f\n",
        1e3 * found.walls->delay_s);
  return text;
}

}  // namespace fusion_slam
