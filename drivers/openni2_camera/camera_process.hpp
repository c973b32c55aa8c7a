// The driver on the bus: CAMERA (each pair, encoded on a thread of its own, the newest first) and
// CAMERA_MODEL (1 Hz) out, COMMAND in; ROBOT_MODEL (1 Hz) too when the robot has no LiDAR whose
// driver would say it.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "bot_core/images_t.hpp"
#include "drivers/openni2_camera/driver.hpp"
#include "drivers/openni2_camera/latest.hpp"
#include "fusion_slam/command_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

// Registers (when `setup` says so), encodes within the message budget; each image keeps its own
// stamp, the message has colour's. Pure.
bot_core::images_t to_message(const FramePair& pair, const CameraSetup& setup, int jpeg_quality,
                              ImageCoding coding = ImageCoding::kPlain);

class CameraProcess {
 public:
  // Starts reading at once. Throws std::runtime_error when the bus is not live: a replay has its
  // own CAMERA.
  CameraProcess(Bus& bus, RobotModel robot, CameraDriverConfig config);
  ~CameraProcess();
  CameraProcess(const CameraProcess&) = delete;
  CameraProcess& operator=(const CameraProcess&) = delete;

 private:
  struct Work {
    FramePair pair;
    CameraSetup setup;
  };
  void read_device();  // own thread
  void publish();      // own thread
  void keep_failure();
  void on_trouble(const std::string& why, bool frames);
  void on_well(const std::string& what);
  void each_second();
  void on_command(const command_t& command);

  Bus& bus_;
  RobotModel robot_;
  int jpeg_quality_;
  ImageCoding coding_;
  std::mutex mutex_;  // guards what follows
  std::optional<CameraSetup> setup_;
  std::string well_;            // empty: no frames now
  std::exception_ptr failure_;  // of a thread
  std::int64_t last_pairs_ = 0;

  Latest<Work> work_;
  std::atomic<bool> stop_{false};
  CameraDriver driver_;
  std::thread reader_, publisher_;
};

}  // namespace fusion_slam
