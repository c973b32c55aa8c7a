// Keeps an RGB-D camera running: finds it, opens it, pairs its images, notices when it is not well,
// says why, and starts over until it is. Knows neither the bus nor the robot.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "drivers/openni2_camera/config.hpp"
#include "drivers/openni2_camera/device.hpp"
#include "drivers/openni2_camera/device_clock.hpp"
#include "drivers/openni2_camera/frame_pairer.hpp"
#include "drivers/openni2_camera/runtime.hpp"
#include "drivers/openni2_camera/uvc_camera.hpp"
#include "libs/camera/depth_registration.hpp"

namespace fusion_slam {

// What follows from the device that was opened.
struct CameraSetup {
  CameraModel model;                              // of colour, and of depth once registered
  std::optional<DepthRegistration> registration;  // we do it; none: depth is as it should be
};
// Throws CameraError when depth has to be registered by us and the file does not say from where.
CameraSetup setup_for(const OpenniDevice& device, const CameraDriverConfig& config);

// All are called on the thread that runs run().
struct CameraEvents {
  std::function<void(const CameraSetup&)> on_open;
  // A pair, depth as the device gave it. Times: us since the epoch.
  std::function<void(FramePair)> on_pair;
  // What is wrong, once for each reason: no frames now (`frames` false), or a frame was dropped.
  std::function<void(const std::string& why, bool frames)> on_trouble;
  // Frames come (again): what runs where and how, after how long and what.
  std::function<void(const std::string& what)> on_well;
  std::function<void()> on_end;  // the recording came to its end; run() returns
};

struct CameraStatistics {
  PairingCounters pairing;  // since the device was opened
  double drift_ppm = 0.0;   // host clock against device clock
  std::int64_t damaged = 0;
  std::int64_t opened = 0;
};

class CameraDriver {
 public:
  CameraDriver(CameraDriverConfig config, CameraEvents events);
  ~CameraDriver();

  // Until `stop` or the recording's end. Whatever the device does is an event, not an exception.
  void run(const std::atomic<bool>& stop);
  void restart() { restart_asked_ = true; }  // closes and opens the device; any thread
  CameraStatistics statistics() const;       // any thread

 private:
  using Us = std::int64_t;  // steady clock
  struct Watch;

  void open();
  void stream(const std::atomic<bool>& stop);
  void take(DeviceFrame frame, Us now_us, Watch* watch);
  void emit(std::optional<FramePair> pair, Us now_us, Watch* watch);
  void supervise(Us now_us, const Watch& watch);
  bool recording_ended(Us now_us, const Watch& watch) const;
  void damaged(bool colour, const std::string& why, Us now_us, Watch* watch);
  void trouble(const std::string& why, bool frames);
  void well(Us now_us);

  CameraDriverConfig config_;
  CameraEvents events_;
  std::atomic<bool> restart_asked_{false};

  std::unique_ptr<OpenniRuntime> runtime_;
  std::unique_ptr<OpenniDevice> device_;
  std::unique_ptr<UvcCamera> uvc_;
  DeviceClock clock_;
  int failures_ = 0;  // to open, in a row

  bool running_ = false;
  std::string last_trouble_;
  Us trouble_since_us_ = 0;
  Us last_report_us_ = 0;
  mutable std::mutex mutex_;  // guards statistics_
  CameraStatistics statistics_;
};

}  // namespace fusion_slam
