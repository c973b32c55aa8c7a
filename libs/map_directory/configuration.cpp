#include "libs/map_directory/configuration.hpp"

#include <cstdio>

#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

template <class... Values>
std::string say(const char* format, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string pose(const char* key, const SE3& T) {
  const Eigen::Quaterniond q(T.linear());
  return say("%s: [%.9g, %.9g, %.9g, %.9g, %.9g, %.9g, %.9g]\n", key, T.translation().x(),
             T.translation().y(), T.translation().z(), q.w(), q.x(), q.y(), q.z());
}

const char* flag(bool value) { return value ? "true" : "false"; }

// A name of any kind as a YAML scalar.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "'";
}

}  // namespace

std::string configuration_yaml(const RobotModel& robot, const std::optional<CameraModel>& camera) {
  std::string yaml = "name: " + quoted(robot.name) + "\n";
  yaml += std::string("reference_frame: ") + to_string(robot.reference_frame) + "\n";
  yaml += std::string("planar: ") + flag(robot.planar) + "\n";
  yaml += std::string("odometry: ") + flag(robot.has_odometry) + "\n";
  yaml += say("map_resolution_m: %.9g\nfloor_clearance_m: %.9g\nrobot_height_m: %.9g\n",
              robot.map_resolution_m, robot.floor_clearance_m, robot.robot_height_m);
  if (robot.has_lidar) {
    yaml += pose("lidar_pose_xyz_m_qwxyz", robot.T_base_lidar);
    yaml +=
        say("lidar:\n  range_min_m: %.9g\n  range_max_m: %.9g\n  sigma_m: %.9g\n  rate_hz: %.9g\n"
            "  beam_period_s: %.9g\n",
            robot.lidar.range_min_m, robot.lidar.range_max_m, robot.lidar.sigma_m,
            robot.lidar.rate_hz, robot.lidar.beam_period_s);
  }
  if (robot.has_camera) yaml += pose("camera_optical_pose_xyz_m_qwxyz", robot.T_base_camera);
  if (camera)
    yaml += say(
        "camera:\n  width_px: %d\n  height_px: %d\n  fx_px: %.9g\n  fy_px: %.9g\n  cx_px: %.9g\n"
        "  cy_px: %.9g\n  depth_min_m: %.9g\n  depth_max_m: %.9g\n  depth_sigma_m: %.9g\n"
        "  depth_sigma_per_m: %.9g\n  rate_hz: %.9g\n",
        camera->width_px, camera->height_px, camera->fx_px, camera->fy_px, camera->cx_px,
        camera->cy_px, camera->depth_min_m, camera->depth_max_m, camera->depth_sigma_m,
        camera->depth_sigma_per_m, camera->rate_hz);
  return yaml;
}

}  // namespace fusion_slam
