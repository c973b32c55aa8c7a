// A driver on a virtual device, and a diary of what it says and publishes.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/rplidar/driver.hpp"
#include "tests/support/virtual_rplidar/virtual_rplidar.hpp"

namespace fusion_slam {

class RplidarRig {
 public:
  struct Entry {
    std::chrono::steady_clock::time_point when;
    std::string text;  // empty: a turn
    bool well = false;
    int wrong_beams = 0;
    double rate_hz = 0.0;
  };

  // Makes a folder of its own for the port.
  RplidarRig(const std::string& model, VirtualWorld world, RplidarConfig config = {});
  ~RplidarRig();
  RplidarRig(const RplidarRig&) = delete;
  RplidarRig& operator=(const RplidarRig&) = delete;

  void plug_in();  // makes the device
  void start();    // the driver; config().port is the device's unless set before
  void stop();
  VirtualRplidar& device() { return *device_; }
  RplidarDriver& driver() { return *driver_; }
  RplidarConfig& config() { return config_; }
  const std::filesystem::path& port() const { return port_; }

  // Waits for something to be true of the diary, 20 s at most (it never takes that long unless
  // something is wrong).
  using Diary = std::vector<Entry>;
  bool wait(const std::function<bool(const Diary&)>& done);
  bool wait_for_text(const std::string& part, std::size_t from = 0);  // in an entry from `from` on
  bool wait_for_turns(int n, std::size_t from = 0);
  Diary diary() const;
  std::size_t now() const { return diary().size(); }  // the next entry's number

 private:
  void add(Entry entry);

  std::filesystem::path folder_;
  std::filesystem::path port_;
  std::string model_;
  VirtualWorld world_;
  RplidarConfig config_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Diary diary_;
  std::unique_ptr<VirtualRplidar> device_;
  std::unique_ptr<RplidarDriver> driver_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace fusion_slam
