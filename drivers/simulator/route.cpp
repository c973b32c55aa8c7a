#include "drivers/simulator/route.hpp"

namespace fusion_slam {
namespace {

RouteCamera read_camera(const YamlSection& route) {
  const YamlSection s(
      route.child("camera"), route.file(),
      {"fx", "fy", "cx", "cy", "width", "height", "rate_hz", "x_m", "z_m", "pitch_deg"});
  RouteCamera camera;
  camera.width_px = static_cast<int>(s.number("width", 16, 4096, camera.width_px));
  camera.height_px = static_cast<int>(s.number("height", 16, 4096, camera.height_px));
  camera.fx_px = s.number("fx", 10.0, 1e4, camera.fx_px);
  camera.fy_px = s.number("fy", 10.0, 1e4, s.has("fx") ? camera.fx_px : camera.fy_px);
  camera.cx_px = s.number("cx", -4096.0, 8192.0, 0.5 * (camera.width_px - 1));
  camera.cy_px = s.number("cy", -4096.0, 8192.0, 0.5 * (camera.height_px - 1));
  camera.rate_hz = s.number("rate_hz", 0.5, 120.0, camera.rate_hz);
  camera.x_m = s.number("x_m", -2.0, 2.0, camera.x_m);
  camera.z_m = s.number("z_m", 0.01, 3.0, camera.z_m);
  camera.pitch_rad = s.number("pitch_deg", -80.0, 80.0, 0.0) * M_PI / 180.0;
  return camera;
}

Route read_route(const YAML::Node& root, const std::string& file) {
  const YamlSection s(root, file,
                      {"name", "route", "seconds", "limits", "camera", "noise", "without"});
  Route route;
  route.name = s.text("name");
  s.child("route");
  route.way_points_m = read_way_points(s);
  route.limits = read_limits(s);
  if (s.has("seconds")) route.seconds = s.number("seconds", 0.5, 36000.0, 60.0);
  if (s.has("camera")) route.camera = read_camera(s);
  if (s.has("noise")) {
    const YAML::Node noise = s.child("noise");
    if (!noise.IsMap()) s.fail(noise, "'noise' must be {name: number, ...}");
    for (const auto& item : noise) {
      double value = NAN;
      if (!item.first.IsScalar() || !item.second.IsScalar() ||
          !YAML::convert<double>::decode(item.second, value) || !std::isfinite(value))
        s.fail(item.first, "'noise' must be {name: number, ...}");
      route.noise[item.first.Scalar()] = {value, s.place(item.first)};
    }
  }
  for (const auto& item : s.list("without")) {
    if (!item.IsScalar()) s.fail(item, "'without' must be a list of names");
    route.without[item.Scalar()] = s.place(item);
  }
  return route;
}

}  // namespace

std::vector<Eigen::Vector2d> read_way_points(const YamlSection& section) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& item : section.list("route")) {
    const auto xy = section.numbers(item, "route", 2, 2);
    points.emplace_back(xy[0], xy[1]);
  }
  if (points.size() < 2)
    section.fail(section.node(), "'route' needs two or more way points [x, y]");
  return points;
}

DriveLimits read_limits(const YamlSection& section) {
  DriveLimits limits;
  if (!section.has("limits")) return limits;
  const YamlSection l(section.child("limits"), section.file(),
                      {"speed_m_s", "turn_rad_s", "accel_m_s2", "turn_accel_rad_s2"});
  limits.max_speed_m_s = l.number("speed_m_s", 0.05, 3.0, limits.max_speed_m_s);
  limits.max_turn_rad_s = l.number("turn_rad_s", 0.05, 6.0, limits.max_turn_rad_s);
  limits.max_accel_m_s2 = l.number("accel_m_s2", 0.05, 10.0, limits.max_accel_m_s2);
  limits.max_turn_accel_rad_s2 =
      l.number("turn_accel_rad_s2", 0.05, 30.0, limits.max_turn_accel_rad_s2);
  return limits;
}

Route route_from_text(const std::string& text, const std::string& file_name) {
  try {
    return read_route(YAML::Load(text), file_name);
  } catch (const YAML::Exception& error) {
    throw ConfigError(file_name + ":" + std::to_string(error.mark.line + 1) +
                      ": not valid YAML: " + error.msg);
  }
}

Route load_route(const std::filesystem::path& path) {
  return route_from_text(text_of_file(path), path.string());
}

}  // namespace fusion_slam
