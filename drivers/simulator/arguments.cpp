#include "drivers/simulator/arguments.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "libs/config/yaml_map.hpp"

namespace fusion_slam {
namespace {

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

double seconds_from(const std::string& text, const std::string& whole) {
  std::size_t used = 0;
  double value = NAN;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != text.size() || !std::isfinite(value) || value < 0.0)
    throw std::invalid_argument("'" + whole + "': '" + text +
                                "' is not a time of the run in seconds");
  return value;
}

TimeSpan span_from(const std::string& from, const std::string& to, const std::string& whole) {
  const TimeSpan span{seconds_from(from, whole), seconds_from(to, whole)};
  if (!(span.from_s < span.to_s))
    throw std::invalid_argument("'" + whole + "' ends before it begins");
  return span;
}

std::string effect_list() {
  std::string text;
  for (const Effect& e : effects()) text += (text.empty() ? "" : ", ") + e.name;
  return text;
}

// The place of a route file's entry goes before what is wrong with it.
template <class Apply>
void apply_at(const std::string& place, const Apply& apply) {
  try {
    apply();
  } catch (const std::invalid_argument& error) {
    throw ConfigError(place + ": " + error.what());
  }
}

}  // namespace

TimeSpan time_span_from(const std::string& text) {
  const auto parts = split(text);
  if (parts.size() != 2)
    throw std::invalid_argument("'" + text + "' must be FROM,TO in seconds, such as 20,22");
  return span_from(parts[0], parts[1], text);
}

Silence silence_from(const std::string& text) {
  const auto parts = split(text);
  if (parts.size() != 3)
    throw std::invalid_argument("'" + text +
                                "' must be SENSOR,FROM,TO in seconds, such as lidar,20,22");
  const std::vector<std::string> names{"camera", "lidar", "odometry"};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (parts[0] == names[i]) return {static_cast<Sensor>(i), span_from(parts[1], parts[2], text)};
  throw std::invalid_argument("there is no sensor '" + parts[0] + "'; the nearest is '" +
                              nearest(parts[0], names) + "'");
}

void add_simulation_arguments(CLI::App& app, SimulationArguments* arguments) {
  SimulationOptions& o = arguments->options;
  app.add_option("WORLD", arguments->world_file,
                 "world file: our own (config/worlds/office.yaml) or a Gazebo .world")
      ->required();
  app.add_option("ROUTE", arguments->route_file,
                 "route file (config/routes); default: the world's own route");
  app.add_option("--seed", o.seed, "equal seeds give equal bytes")->capture_default_str();
  app.add_option("--seconds", o.seconds, "how long to drive; default: the route's, else 60")
      ->check(CLI::Range(0.5, 36000.0));
  app.add_option("--camera-hz", o.camera_hz,
                 "camera frames a second; default: the route's camera's, else 30")
      ->check(CLI::Range(0.5, 120.0));
  app.add_option("--lidar-hz", o.lidar_hz, "turns of the LiDAR a second")
      ->check(CLI::Range(1.0, 20.0))
      ->capture_default_str();
  app.add_option("--threads", o.threads, "frames rendered at the same time")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_flag("--random-route", o.random_route,
               "safe way points from the seed, from the route's first on");
  app.add_flag("--hand-held", o.hand_held,
               "the camera alone, carried along the route with swaying height and direction");
  app.add_flag("--no-noise", arguments->no_noise, "ideal sensors and wheels: --without all");
  app.add_option("--without", arguments->without,
                 "leave these effects out, or `all`: " + effect_list())
      ->delimiter(',');
  app.add_option("--with", arguments->with, "put these effects back in")->delimiter(',');
  app.add_option("--cover-camera", arguments->cover_camera,
                 "FROM,TO: seconds for which the lens is covered (black frames); may be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--sensor-silent", arguments->sensor_silent,
                 "camera|lidar|odometry,FROM,TO: seconds without its messages; may be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--lidar-at", arguments->lidar_at,
                 "x,y,z,roll,pitch,yaw (m, degrees): where the LiDAR truly sits; ROBOT_MODEL keeps "
                 "saying what is on paper, and `calibrate` has something to find")
      ->delimiter(',')
      ->expected(6);
  app.add_option("--camera-at", arguments->camera_at, "the same for the camera")
      ->delimiter(',')
      ->expected(6);
  app.add_option_function<double>(
         "--camera-late-ms", [&o](double ms) { o.camera_stamps_late_s = 1e-3 * ms; },
         "how much later than the truth the camera's stamps are")
      ->check(CLI::Range(-500.0, 500.0));
}

SimulationInput read_simulation(const SimulationArguments& arguments) {
  SimulationInput input;
  input.options = arguments.options;
  SensorNoise& noise = input.options.noise;
  for (const auto& text : arguments.cover_camera)
    input.options.covered.push_back(time_span_from(text));
  for (const auto& text : arguments.sensor_silent)
    input.options.silent.push_back(silence_from(text));
  if (!arguments.route_file.empty()) {
    input.route = load_route(arguments.route_file);
    for (const auto& [name, value] : input.route->noise)
      apply_at(value.place, [&, n = name, v = value.value] { set_parameter(n, v, &noise); });
    for (const auto& [name, place] : input.route->without)
      apply_at(place, [&, n = name] { set_effect(n, false, &noise); });
  }
  const auto mount = [](const std::vector<double>& v) {
    const double rad = M_PI / 180.0;
    return from_xyz_rpy(v[0], v[1], v[2], rad * v[3], rad * v[4], rad * v[5]);
  };
  if (!arguments.lidar_at.empty()) input.options.T_base_lidar = mount(arguments.lidar_at);
  if (!arguments.camera_at.empty()) {
    input.options.T_base_camera = mount(arguments.camera_at);
    input.options.T_base_camera->linear() *= optical_to_body();
  }
  if (arguments.no_noise) set_effect("all", false, &noise);
  for (const auto& name : arguments.without) set_effect(name, false, &noise);
  for (const auto& name : arguments.with) set_effect(name, true, &noise);
  input.world = load_world(arguments.world_file);
  return input;
}

}  // namespace fusion_slam
