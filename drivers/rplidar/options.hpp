// The process's command line and configuration files, joined: what is said on the command line
// wins.
#pragma once

#include <string>

#include "drivers/rplidar/config.hpp"
#include "libs/robot/robot_model.hpp"

namespace CLI {
class App;
}

namespace fusion_slam {

struct RplidarOptions {
  std::string robot;  // config/robots/NAME.yaml, or a file's path
  // Empty or 0: as the LiDAR's sensor file says.
  std::string port;
  int baud = 0;
  std::string model;
  std::string scan_mode;
};

// --robot, --port, --baud, --model, --scan-mode, and --list, which prints this machine's serial
// ports and ends the program.
void add_options(CLI::App& app, RplidarOptions* options);

struct RplidarSetup {
  RobotModel robot;
  RplidarConfig config;
};
// Throws ConfigError: no such robot, a robot without LiDAR, a wrong key.
RplidarSetup load_setup(const RplidarOptions& options);

}  // namespace fusion_slam
