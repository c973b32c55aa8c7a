// Keeps an RPLidar scanning: finds it, starts it, reads it, notices when it is not well, says why,
// and starts over until it is. Knows neither the bus nor the robot.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/rplidar/config.hpp"
#include "drivers/rplidar/device.hpp"
#include "drivers/rplidar/scan_parser.hpp"
#include "drivers/rplidar/serial_port.hpp"

namespace fusion_slam {

// All are called on the thread that runs run().
struct RplidarEvents {
  // The device answered and is about to scan.
  std::function<void(const RplidarInfo&, const ScanMode&)> on_mode;
  // A whole, undamaged turn of a motor at speed. Times: us since the epoch.
  std::function<void(const Revolution&)> on_turn;
  // What is wrong, once for each reason: no scans now (`scans` false), or a turn was dropped
  // (true).
  std::function<void(const std::string& why, bool scans)> on_trouble;
  // Scans come (again): what scans where and how fast, after how long and what.
  std::function<void(const std::string& what)> on_well;
};

class RplidarDriver {
 public:
  RplidarDriver(RplidarConfig config, RplidarEvents events);
  ~RplidarDriver();

  // Until `stop`; then ends the scan and halts the motor. Whatever the device does is an event, not
  // an exception.
  void run(const std::atomic<bool>& stop);

  // Reboots the device and starts over; any thread.
  void restart() { restart_asked_ = true; }

 private:
  using Us = std::int64_t;  // steady clock
  struct Watch;             // what the supervision of one scan remembers

  void open_port();
  void bring_up();
  void check_health(RplidarDevice* device);
  void await_boot();
  void scan(const std::atomic<bool>& stop);
  void take_turns(std::vector<Revolution>* turns, Us now_us, Watch* watch);
  void supervise(const ScanParser& parser, Us now_us, Watch* watch);
  void trouble(const std::string& why, bool scans);
  void motor_trouble(const std::string& why);
  void well(const Revolution& turn, Us now_us);
  void shut_down();
  std::vector<int> bauds() const;

  RplidarConfig config_;
  RplidarEvents events_;
  std::atomic<bool> restart_asked_{false};

  std::unique_ptr<SerialPort> port_;
  bool identified_ = false;  // the open port has an RPLidar behind it
  int attempt_ = 0;          // which of ports and speeds is next
  int failures_ = 0;         // of an identified device, in a row
  int known_baud_ = 0;       // the last one that worked
  RplidarInfo info_;
  ScanMode mode_;
  std::vector<std::uint8_t> first_bytes_;

  bool scanning_ = false;
  std::string last_trouble_;
  Us trouble_since_us_ = 0;
  Us last_dropped_us_ = 0;
};

}  // namespace fusion_slam
