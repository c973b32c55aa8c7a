// calibrate: the mounting of the sensors from a drive.
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "libs/calibration/extrinsics.hpp"
#include "logplayer/calibrate/read_drive.hpp"

int main(int argc, char** argv) {
  CLI::App app("Where the camera and the LiDAR sit on the robot, from one ordinary drive",
               "calibrate");
  std::string log;
  auto* extrinsics = app.add_subcommand("extrinsics",
                                        "camera: height, roll, pitch (floor), x, y, yaw and clock "
                                        "(against the LiDAR's walls); LiDAR: x, y, "
                                        "yaw (against the wheels)");
  extrinsics
      ->add_option("LOG", log, "LCM log with ROBOT_MODEL, CAMERA, CAMERA_MODEL, LIDAR, ODOMETRY")
      ->required();
  extrinsics->footer(
      "Drive for a minute or two as you please: with turns both ways, past walls in two "
      "directions, "
      "with floor in view.\nPrints each number with its uncertainty (1 sigma) and the lines for "
      "the "
      "robot's and the camera's file. What the\ndrive did not show stays as it is on paper "
      "(ROBOT_MODEL), and the report says so.");
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const bool terminal = isatty(2) != 0;
    const auto drive = fusion_slam::read_drive(log, [&](double done) {
      if (terminal)
        std::cerr << "\rreading " << static_cast<int>(100.0 * done) << " %" << std::flush;
    });
    if (terminal) std::cerr << "\r              \r";
    std::cout << fusion_slam::report(fusion_slam::calibrate_extrinsics(drive), drive.robot);
    return std::cout.flush() ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << "calibrate: " << error.what() << "\n";
    return 1;
  }
}
