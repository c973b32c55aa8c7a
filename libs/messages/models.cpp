#include "libs/messages/models.hpp"

#include <cmath>

#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

bool finite_positive(double v) { return std::isfinite(v) && v > 0.0; }
bool finite_not_negative(double v) { return std::isfinite(v) && v >= 0.0; }

}  // namespace

camera_model_t to_message(const CameraModel& model, std::int64_t utime_us) {
  camera_model_t m{};
  m.utime = utime_us;
  m.width = model.width_px;
  m.height = model.height_px;
  m.fx = model.fx_px;
  m.fy = model.fy_px;
  m.cx = model.cx_px;
  m.cy = model.cy_px;
  for (int i = 0; i < 5; ++i) m.distortion[i] = model.distortion[static_cast<std::size_t>(i)];
  m.depth_min_m = model.depth_min_m;
  m.depth_max_m = model.depth_max_m;
  m.depth_sigma_m = model.depth_sigma_m;
  m.depth_sigma_per_m = model.depth_sigma_per_m;
  m.rate_hz = model.rate_hz;
  return m;
}

std::optional<CameraModel> from_message(const camera_model_t& m, std::string* why) {
  if (m.width <= 0 || m.height <= 0 || m.width > 8192 || m.height > 8192)
    return *why = "image size is not between 1 and 8192 pixels", std::nullopt;
  if (!finite_positive(m.fx) || !finite_positive(m.fy) || !std::isfinite(m.cx) ||
      !std::isfinite(m.cy))
    return *why = "focal length or principal point is not a positive number", std::nullopt;
  if (!finite_not_negative(m.depth_min_m) || !finite_positive(m.depth_max_m) ||
      !finite_not_negative(m.depth_sigma_m) || !finite_not_negative(m.depth_sigma_per_m))
    return *why = "depth range or noise is not a positive number", std::nullopt;
  CameraModel model;
  model.width_px = m.width;
  model.height_px = m.height;
  model.fx_px = m.fx;
  model.fy_px = m.fy;
  model.cx_px = m.cx;
  model.cy_px = m.cy;
  for (int i = 0; i < 5; ++i) {
    if (!std::isfinite(m.distortion[i]))
      return *why = "distortion is not a finite number", std::nullopt;
    model.distortion[static_cast<std::size_t>(i)] = m.distortion[i];
  }
  model.depth_min_m = m.depth_min_m;
  model.depth_max_m = m.depth_max_m;
  model.depth_sigma_m = m.depth_sigma_m;
  model.depth_sigma_per_m = m.depth_sigma_per_m;
  model.rate_hz = m.rate_hz;
  return model;
}

robot_model_t to_message(const RobotModel& model, std::int64_t utime_us) {
  robot_model_t m{};
  m.utime = utime_us;
  m.name = model.name;
  m.reference_frame = to_string(model.reference_frame);
  m.has_lidar = model.has_lidar;
  m.has_camera = model.has_camera;
  m.has_odometry = model.has_odometry;
  m.planar = model.planar;
  m.T_base_lidar = to_message(model.T_base_lidar, utime_us);
  m.T_base_camera = to_message(model.T_base_camera, utime_us);
  m.lidar_range_min_m = model.lidar.range_min_m;
  m.lidar_range_max_m = model.lidar.range_max_m;
  m.lidar_sigma_m = model.lidar.sigma_m;
  m.lidar_rate_hz = model.lidar.rate_hz;
  m.lidar_beam_period_s = model.lidar.beam_period_s;
  m.map_resolution_m = model.map_resolution_m;
  m.floor_clearance_m = model.floor_clearance_m;
  m.robot_height_m = model.robot_height_m;
  return m;
}

std::optional<RobotModel> from_message(const robot_model_t& m, std::string* why) {
  RobotModel model;
  model.name = m.name;
  const auto frame = reference_frame_from(m.reference_frame);
  if (!frame)
    return *why = "reference_frame '" + m.reference_frame + "' is not base, camera or lidar",
           std::nullopt;
  model.reference_frame = *frame;
  model.has_lidar = m.has_lidar != 0;
  model.has_camera = m.has_camera != 0;
  model.has_odometry = m.has_odometry != 0;
  model.planar = m.planar != 0;
  const auto T_base_lidar = from_message(m.T_base_lidar);
  const auto T_base_camera = from_message(m.T_base_camera);
  if (!T_base_lidar || !T_base_camera)
    return *why = "T_base_lidar or T_base_camera is not a rigid motion", std::nullopt;
  model.T_base_lidar = *T_base_lidar;
  model.T_base_camera = *T_base_camera;
  if (!finite_not_negative(m.lidar_range_min_m) || !finite_positive(m.lidar_range_max_m) ||
      !finite_positive(m.lidar_sigma_m) || !std::isfinite(m.lidar_beam_period_s) ||
      !std::isfinite(m.lidar_rate_hz))
    return *why = "a lidar_* value is not a positive number", std::nullopt;
  model.lidar = {m.lidar_range_min_m, m.lidar_range_max_m, m.lidar_sigma_m, m.lidar_rate_hz,
                 m.lidar_beam_period_s};
  if (!(m.map_resolution_m >= 0.005 && m.map_resolution_m <= 1.0))
    return *why = "map_resolution_m is not between 0.005 and 1", std::nullopt;
  if (!std::isfinite(m.floor_clearance_m) || !finite_positive(m.robot_height_m))
    return *why = "floor_clearance_m or robot_height_m is not a number", std::nullopt;
  model.map_resolution_m = m.map_resolution_m;
  model.floor_clearance_m = m.floor_clearance_m;
  model.robot_height_m = m.robot_height_m;
  return model;
}

bot_core::planar_lidar_t to_message(const LaserScan& scan) {
  bot_core::planar_lidar_t m{};
  m.utime = scan.utime_us;
  m.nranges = static_cast<std::int32_t>(scan.ranges_m.size());
  m.ranges = scan.ranges_m;
  m.nintensities = static_cast<std::int32_t>(scan.intensities.size());
  m.intensities = scan.intensities;
  m.rad0 = static_cast<float>(scan.rad0);
  m.radstep = static_cast<float>(scan.radstep);
  return m;
}

std::optional<LaserScan> from_message(const bot_core::planar_lidar_t& m, std::string* why) {
  if (!std::isfinite(m.rad0) || !std::isfinite(m.radstep) || m.radstep == 0.0F)
    return *why = "rad0 or radstep is not a usable angle", std::nullopt;
  LaserScan scan;
  scan.utime_us = m.utime;
  scan.rad0 = m.rad0;
  scan.radstep = m.radstep;
  scan.ranges_m = m.ranges;
  scan.intensities = m.intensities;
  return scan;
}

const char* to_string(ReferenceFrame frame) {
  switch (frame) {
    case ReferenceFrame::kCamera:
      return "camera";
    case ReferenceFrame::kLidar:
      return "lidar";
    case ReferenceFrame::kBase:
      break;
  }
  return "base";
}

std::optional<ReferenceFrame> reference_frame_from(const std::string& text) {
  for (const auto frame : {ReferenceFrame::kBase, ReferenceFrame::kCamera, ReferenceFrame::kLidar})
    if (text == to_string(frame)) return frame;
  return std::nullopt;
}

}  // namespace fusion_slam
