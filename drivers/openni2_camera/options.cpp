#include "drivers/openni2_camera/options.hpp"

#include <filesystem>
#include <iostream>

#include <CLI/CLI.hpp>

#include "drivers/openni2_camera/runtime.hpp"
#include "libs/config/robot_config.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

void print_devices() {
  try {
    const OpenniRuntime runtime;
    const auto devices = runtime.devices();
    for (const CameraCandidate& device : devices)
      std::cout << device.uri << "  " << device.name << "\n";
    if (devices.empty()) std::cout << describe(devices) << "\n";
  } catch (const CameraError& error) {
    std::cerr << "openni2_camera: " << error.what() << "\n";
    throw CLI::RuntimeError(1);
  }
}

void override_with(const std::string& option, std::string* value) {
  if (!option.empty()) *value = option;
}

}  // namespace

void add_options(CLI::App& app, CameraOptions* options) {
  app.add_option("--robot", options->robot,
                 "the robot: a name in config/robots, or a file (mounting, camera)")
      ->required();
  app.add_option("--calibration", options->calibration,
                 "a camera file (like config/sensors/orbbec-astra.yaml) instead of the robot's")
      ->check(CLI::ExistingFile);
  auto* uri = app.add_option("--uri", options->uri,
                             "which device, as --list prints it; without: the first");
  app.add_option("--file", options->file, "play a recording (.oni) instead; ends with it")
      ->check(CLI::ExistingFile)
      ->excludes(uri);
  app.add_flag("--repeat", options->repeat, "play the recording again and again");
  app.add_option("--colour", options->colour,
                 "where colour comes from: openni2, or a UVC camera like /dev/video0");
  app.add_option(
         "--registration", options->registration,
         "who moves depth into colour's view: auto (the device if it can), device, own, none")
      ->check(CLI::IsMember({"auto", "device", "own", "none"}));
  app.add_option("--intrinsics", options->intrinsics,
                 "focal lengths from the camera's file, or what the device says")
      ->check(CLI::IsMember({"file", "device"}));
  app.add_option("--auto-exposure", options->auto_exposure)->check(CLI::IsMember({"on", "off"}));
  app.add_option("--images", options->images,
                 "plain, or packed: half of the network; only Fusion-SLAM reads such depth")
      ->check(CLI::IsMember({"plain", "packed"}));
  app.add_option("--jpeg-quality", options->jpeg_quality)->check(CLI::Range(30, 100));
  app.add_flag_callback(
      "--list",
      [] {
        print_devices();
        throw CLI::Success();
      },
      "print the OpenNI2 devices of this machine and end");
  app.footer(
      "Publishes CAMERA and CAMERA_MODEL (and ROBOT_MODEL for a robot without LiDAR). Looks for "
      "the "
      "device for as\nlong as it takes, and again after it was unplugged or fell silent; STATUS "
      "says "
      "what it is doing. Ends with 0\nwhen asked to (Ctrl-C, COMMAND quit) or with its recording, "
      "1 on "
      "a failure, 2 on wrong usage. COMMAND reset\ncloses and opens the device.");
}

CameraProcessSetup load_setup(const CameraOptions& options) {
  const RobotConfig robot = find_robot(options.robot);
  if (!robot.robot.has_camera)
    throw ConfigError(options.robot + ": robot '" + robot.robot.name +
                      "' has no camera: add the key 'camera'");
  const fs::path camera_file =
      options.calibration.empty() ? robot.camera_file : fs::path(options.calibration);
  CameraProcessSetup setup;
  setup.robot = robot.robot;
  setup.config.camera = load_camera_model(camera_file);
  CameraConnection& connection = setup.config.connection;
  connection = load_camera_connection(camera_file);
  setup.config.file = options.file;
  setup.config.repeat = options.repeat;
  override_with(options.uri, &connection.uri);
  override_with(options.colour, &connection.colour);
  override_with(options.registration, &connection.registration);
  override_with(options.intrinsics, &connection.intrinsics);
  override_with(options.images, &connection.images);
  if (options.jpeg_quality > 0) connection.jpeg_quality = options.jpeg_quality;
  if (!options.auto_exposure.empty()) connection.auto_exposure = options.auto_exposure == "on";
  return setup;
}

}  // namespace fusion_slam
