// The driver on the bus: LIDAR (each turn, from the thread that reads the device: Bus::publish may
// be called from any) and ROBOT_MODEL (1 Hz) out, COMMAND in.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/rplidar/driver.hpp"
#include "fusion_slam/command_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

class RplidarProcess {
 public:
  // Starts reading at once. Throws std::runtime_error when the bus is not live: a replay has its
  // own LIDAR.
  RplidarProcess(Bus& bus, RobotModel robot, RplidarConfig config);
  ~RplidarProcess();  // ends the scan, halts the motor
  RplidarProcess(const RplidarProcess&) = delete;
  RplidarProcess& operator=(const RplidarProcess&) = delete;

 private:
  void read_device();  // own thread
  void on_mode(const ScanMode& mode);
  void on_turn(const Revolution& turn);
  void on_trouble(const std::string& why, bool scans);
  void on_well(const std::string& what);
  void each_second();
  void on_command(const command_t& command);
  double beam_period_s();

  Bus& bus_;
  std::mutex mutex_;  // guards what follows
  RobotModel robot_;  // its beam period is the device's once that is known, and then stays
  bool announced_ = false;
  std::exception_ptr failure_;  // of the reading thread

  std::chrono::steady_clock::time_point start_;
  std::atomic<bool> stop_{false};
  RplidarDriver driver_;
  std::thread reader_;
};

}  // namespace fusion_slam
