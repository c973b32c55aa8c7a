#include "drivers/rplidar/options.hpp"

#include <iostream>

#include <CLI/CLI.hpp>

#include "drivers/rplidar/port_finder.hpp"
#include "libs/config/robot_config.hpp"
#include "libs/config/sensors.hpp"

namespace fusion_slam {
namespace {

void print_ports() {
  const auto ports = serial_ports();
  for (const PortCandidate& port : ports)
    std::cout << port.path << "  " << port.description
              << (port.likely ? "  <- the adapter that Slamtec ships\n" : "\n");
  if (ports.empty()) std::cout << describe_ports(ports) << "\n";
}

}  // namespace

void add_options(CLI::App& app, RplidarOptions* options) {
  app.add_option("--robot", options->robot,
                 "the robot: a name in config/robots, or a file (mounting, LiDAR)")
      ->required();
  app.add_option("--port", options->port,
                 "serial port, or a pattern like '/dev/ttyUSB*'; without: the adapter that Slamtec "
                 "ships (CP210x) is looked for");
  app.add_option("--baud", options->baud, "line speed; without: that of the model is found")
      ->check(CLI::Range(1'200, 4'000'000));
  app.add_option("--model", options->model, "refuse any other model than this one")
      ->check(CLI::IsMember({"a1", "a2", "a3", "c1", "s1", "s2", "s3"}));
  app.add_option("--scan-mode", options->scan_mode, "auto: the most measurements per second")
      ->check(CLI::IsMember({"auto", "standard", "express", "dense"}));
  app.add_flag_callback(
      "--list",
      [] {
        print_ports();
        throw CLI::Success();
      },
      "print this machine's serial ports and end");
  app.footer(
      "Publishes LIDAR and ROBOT_MODEL. Looks for the device for as long as it takes, and again "
      "after it was\nunplugged or fell silent; STATUS says what it is doing. Ends with 0 when "
      "asked "
      "to (Ctrl-C, COMMAND quit),\n1 on a failure, 2 on wrong usage. COMMAND reset reboots the "
      "device.");
}

RplidarSetup load_setup(const RplidarOptions& options) {
  const RobotConfig robot = find_robot(options.robot);
  if (!robot.robot.has_lidar)
    throw ConfigError(options.robot + ": robot '" + robot.robot.name +
                      "' has no LiDAR: add the key 'lidar'");
  const LidarConnection connection = load_lidar_connection(robot.lidar_file);
  RplidarSetup setup;
  setup.robot = robot.robot;
  setup.config.port = options.port.empty() ? connection.port : options.port;
  setup.config.baud = options.baud == 0 ? connection.baud : options.baud;
  setup.config.model = options.model.empty() ? connection.model : options.model;
  setup.config.scan_mode = options.scan_mode.empty() ? connection.scan_mode : options.scan_mode;
  return setup;
}

}  // namespace fusion_slam
