// The process's command line and configuration files, joined: what is said on the command line
// wins.
#pragma once

#include <string>

#include "drivers/openni2_camera/config.hpp"
#include "libs/robot/robot_model.hpp"

namespace CLI {
class App;
}

namespace fusion_slam {

struct CameraOptions {
  std::string robot;        // config/robots/NAME.yaml, or a file's path
  std::string calibration;  // a camera file instead of the robot's
  std::string file;         // .oni
  bool repeat = false;
  // Empty: as the camera's file says.
  std::string uri, colour, registration, intrinsics, auto_exposure, images;
  int jpeg_quality = 0;  // 0: as the camera's file says
};

// Adds the options, and --list, which prints the OpenNI2 devices of this machine and ends.
void add_options(CLI::App& app, CameraOptions* options);

struct CameraProcessSetup {
  RobotModel robot;
  CameraDriverConfig config;
};
// Throws ConfigError: no such robot, a robot without camera, a wrong key, no such recording.
CameraProcessSetup load_setup(const CameraOptions& options);

}  // namespace fusion_slam
