#include <memory>

#include "drivers/rplidar/options.hpp"
#include "drivers/rplidar/rplidar_process.hpp"
#include "libs/bus/process.hpp"

int main(int argc, char** argv) {
  fusion_slam::RplidarOptions options;
  return fusion_slam::process_main(
      argc, argv, "rplidar", "Reads a Slamtec RPLidar and publishes its turns.",
      [&](fusion_slam::Bus& bus) {
        const fusion_slam::RplidarSetup setup = fusion_slam::load_setup(options);
        return std::make_shared<fusion_slam::RplidarProcess>(bus, setup.robot, setup.config);
      },
      [&](CLI::App& app) { fusion_slam::add_options(app, &options); });
}
