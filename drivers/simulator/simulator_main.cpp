// simulator: a simulated robot on the LCM network, live.
#include <memory>

#include "drivers/simulator/simulator_process.hpp"
#include "libs/bus/process.hpp"

int main(int argc, char** argv) {
  fusion_slam::SimulationArguments arguments;
  return fusion_slam::process_main(
      argc, argv, "simulator",
      "A simulated robot, live: CAMERA, CAMERA_MODEL, LIDAR, ROBOT_MODEL, ODOMETRY, GROUND_TRUTH",
      [&](fusion_slam::Bus& bus) {
        return std::make_shared<fusion_slam::SimulatorProcess>(bus, arguments);
      },
      [&](CLI::App& app) { fusion_slam::add_simulation_arguments(app, &arguments); });
}
