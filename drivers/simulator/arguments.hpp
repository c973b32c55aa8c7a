// What both programs of the simulator take on the command line: a world, a route, a seed, and what
// the sensors do wrong.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulator/simulation.hpp"

namespace CLI {
class App;
}

namespace fusion_slam {

struct SimulationArguments {
  std::filesystem::path world_file;
  std::filesystem::path route_file;  // empty: the world's own
  bool no_noise = false;
  std::vector<std::string> with, without;  // effects
  std::vector<std::string> cover_camera;   // FROM,TO
  std::vector<std::string> sensor_silent;  // SENSOR,FROM,TO
  std::vector<double> lidar_at,
      camera_at;              // x, y, z (m), roll, pitch, yaw (deg); empty: as on paper
  SimulationOptions options;  // the rest
};

// Adds WORLD, ROUTE and options to `app`; `arguments` must outlive its parsing.
void add_simulation_arguments(CLI::App& app, SimulationArguments* arguments);

// The world and route files read, and the arguments' own texts put into `options`: defaults, then
// the route's noise, then the command line's. Throws std::runtime_error or std::invalid_argument
// with the argument or file, line and what to do.
struct SimulationInput {
  World world;
  std::optional<Route> route;
  SimulationOptions options;
};
SimulationInput read_simulation(const SimulationArguments& arguments);

// Texts of --cover-camera and --sensor-silent. Throw std::invalid_argument.
TimeSpan time_span_from(const std::string& text);  // "12,14.5"
Silence silence_from(const std::string& text);     // "lidar,12,14.5"

}  // namespace fusion_slam
