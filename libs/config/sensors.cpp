#include "libs/config/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "libs/config/yaml_map.hpp"

namespace fusion_slam {
namespace {

const std::vector<std::string> kLidarKeys = {"kind",    "range_min_m",   "range_max_m", "sigma_m",
                                             "rate_hz", "beam_period_s", "port",        "baud",
                                             "model",   "scan_mode"};
const std::vector<std::string> kCameraKeys = {
    "kind", "width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", "distortion",
    "depth_min_m", "depth_max_m", "depth_sigma_m", "depth_sigma_per_m", "rate_hz",
    // how to reach it
    "uri", "colour", "intrinsics", "registration", "auto_exposure", "jpeg_quality", "images",
    "stamp_offset_ms", "depth_fx_px", "depth_fy_px", "depth_cx_px", "depth_cy_px",
    "depth_mount_xyz_m_rpy_deg"};

}  // namespace

LidarModel load_lidar_model(const std::filesystem::path& path) {
  const YamlMap map = YamlMap::from_file(path, kLidarKeys);
  map.choice("kind", {"lidar"}, "lidar");
  LidarModel model;
  model.range_min_m = map.number("range_min_m", 0.0, 10.0, model.range_min_m);
  model.range_max_m = map.number("range_max_m", 0.5, 500.0, model.range_max_m);
  model.sigma_m = map.number("sigma_m", 0.0005, 1.0, model.sigma_m);
  model.rate_hz = map.number("rate_hz", 0.1, 200.0, model.rate_hz);
  model.beam_period_s = map.number("beam_period_s", 0.0, 0.1, model.beam_period_s);
  if (model.range_min_m >= model.range_max_m) map.fail("range_min_m", "is not below range_max_m");
  return model;
}

LidarConnection load_lidar_connection(const std::filesystem::path& path) {
  const YamlMap map = YamlMap::from_file(path, kLidarKeys);
  LidarConnection connection;
  connection.port = map.text("port", "");
  connection.baud = static_cast<int>(map.number("baud", 0, 4'000'000, 0));
  if (map.has("model"))
    connection.model = map.choice("model", {"a1", "a2", "a3", "c1", "s1", "s2", "s3"}, "");
  connection.scan_mode =
      map.choice("scan_mode", {"auto", "standard", "express", "dense"}, connection.scan_mode);
  return connection;
}

CameraModel load_camera_model(const std::filesystem::path& path) {
  const YamlMap map = YamlMap::from_file(path, kCameraKeys);
  map.choice("kind", {"camera"}, "camera");
  CameraModel m;
  m.width_px = static_cast<int>(map.number("width_px", 16, 8192, m.width_px));
  m.height_px = static_cast<int>(map.number("height_px", 16, 8192, m.height_px));
  m.fx_px = map.number("fx_px", 10.0, 20000.0, m.fx_px);
  m.fy_px = map.number("fy_px", 10.0, 20000.0, m.fy_px);
  m.cx_px = map.number("cx_px", 0.0, 8192.0, m.cx_px);
  m.cy_px = map.number("cy_px", 0.0, 8192.0, m.cy_px);
  const auto k = map.numbers("distortion", 5, -10.0, 10.0, {0, 0, 0, 0, 0});
  std::copy(k.begin(), k.end(), m.distortion.begin());
  m.depth_min_m = map.number("depth_min_m", 0.0, 10.0, m.depth_min_m);
  m.depth_max_m = map.number("depth_max_m", 0.2, 65.0, m.depth_max_m);
  m.depth_sigma_m = map.number("depth_sigma_m", 0.0, 0.1, m.depth_sigma_m);
  m.depth_sigma_per_m = map.number("depth_sigma_per_m", 0.0, 0.1, m.depth_sigma_per_m);
  m.rate_hz = map.number("rate_hz", 0.1, 200.0, m.rate_hz);
  if (m.depth_min_m >= m.depth_max_m) map.fail("depth_min_m", "is not below depth_max_m");
  return m;
}

CameraConnection load_camera_connection(const std::filesystem::path& path) {
  const YamlMap map = YamlMap::from_file(path, kCameraKeys);
  CameraConnection c;
  c.uri = map.text("uri", "");
  c.colour = map.text("colour", c.colour);
  if (c.colour != "openni2" && c.colour.find('/') == std::string::npos)
    map.fail("colour", "is neither openni2 nor a device like /dev/video0");
  c.intrinsics = map.choice("intrinsics", {"file", "device"}, c.intrinsics);
  c.registration = map.choice("registration", {"auto", "device", "own", "none"}, c.registration);
  c.auto_exposure = map.flag("auto_exposure", c.auto_exposure);
  c.jpeg_quality = static_cast<int>(map.number("jpeg_quality", 30, 100, c.jpeg_quality));
  c.images = map.choice("images", {"plain", "packed"}, c.images);
  c.stamp_offset_ms = map.number("stamp_offset_ms", -1000.0, 1000.0, 0.0);
  if (map.has("depth_fx_px")) {
    c.depth_fx_px = map.require_number("depth_fx_px", 10.0, 20000.0);
    c.depth_fy_px = map.require_number("depth_fy_px", 10.0, 20000.0);
    c.depth_cx_px = map.require_number("depth_cx_px", 0.0, 8192.0);
    c.depth_cy_px = map.require_number("depth_cy_px", 0.0, 8192.0);
  }
  if (map.has("depth_mount_xyz_m_rpy_deg")) {
    const auto v = map.numbers("depth_mount_xyz_m_rpy_deg", 6, -360.0, 360.0, {});
    const double deg = M_PI / 180.0;
    c.T_colour_depth = from_xyz_rpy(v[0], v[1], v[2], v[3] * deg, v[4] * deg, v[5] * deg);
  }
  return c;
}

std::vector<std::string> sensor_names(const std::filesystem::path& directory,
                                      const std::string& kind) {
  std::vector<std::string> names;
  if (!std::filesystem::is_directory(directory)) return names;
  std::vector<std::string> all_keys = kLidarKeys;
  all_keys.insert(all_keys.end(), kCameraKeys.begin(), kCameraKeys.end());
  for (const auto& file : std::filesystem::directory_iterator(directory)) {
    if (file.path().extension() != ".yaml") continue;
    const YamlMap map = YamlMap::from_file(file.path(), all_keys);
    if (map.text("kind", "") == kind) names.push_back(file.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace fusion_slam
