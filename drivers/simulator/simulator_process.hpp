// The simulator as a driver: publishes a simulated run on LCM, live.
#pragma once

#include <memory>
#include <thread>

#include "drivers/simulator/arguments.hpp"
#include "drivers/simulator/live_run.hpp"
#include "libs/bus/bus.hpp"

namespace fusion_slam {

class SimulatorProcess {
 public:
  // Reads the files (throws what is wrong with them), starts publishing CAMERA, CAMERA_MODEL,
  // LIDAR, ROBOT_MODEL, ODOMETRY and GROUND_TRUTH, and stops the bus at the end of the run. STATUS
  // says how far it is and how many frames the machine was too slow for.
  SimulatorProcess(Bus& bus, const SimulationArguments& arguments);
  ~SimulatorProcess();
  SimulatorProcess(const SimulatorProcess&) = delete;
  SimulatorProcess& operator=(const SimulatorProcess&) = delete;

 private:
  SimulatorProcess(Bus& bus, const SimulationInput& input);
  void tell();

  Bus& bus_;
  Simulation simulation_;
  LiveRun live_;
  std::thread thread_;
};

}  // namespace fusion_slam
