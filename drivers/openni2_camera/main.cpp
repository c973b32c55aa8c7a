#include <cstdlib>
#include <memory>

#include "drivers/openni2_camera/camera_process.hpp"
#include "drivers/openni2_camera/options.hpp"
#include "libs/bus/process.hpp"

int main(int argc, char** argv) {
  // OpenCV waits 10 s for a UVC camera that fell silent, unless told otherwise.
  setenv("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "1", 0);
  fusion_slam::CameraOptions options;
  return fusion_slam::process_main(
      argc, argv, "openni2_camera",
      "Reads an RGB-D camera through OpenNI2 and publishes its frames.",
      [&](fusion_slam::Bus& bus) {
        const fusion_slam::CameraProcessSetup setup = fusion_slam::load_setup(options);
        return std::make_shared<fusion_slam::CameraProcess>(bus, setup.robot, setup.config);
      },
      [&](CLI::App& app) { fusion_slam::add_options(app, &options); });
}
