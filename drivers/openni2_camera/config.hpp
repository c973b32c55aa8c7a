// What the driver needs to know. Times: why they are what they are; nobody has to set them.
#pragma once

#include <filesystem>
#include <string>

#include "libs/camera/camera_model.hpp"
#include "libs/config/sensors.hpp"

namespace fusion_slam {

struct CameraDriverConfig {
  CameraModel camera;           // size, rate and intrinsics of colour, from the sensor file
  CameraConnection connection;  // a user's choices
  std::filesystem::path file;   // a recording (.oni) instead of a device
  bool repeat = false;          // the recording, from its start again

  // A camera of 30 Hz that misses 15 frames in a row is not well.
  int silence_ms = 500;
  // Devices need up to a second and a half from start to first frame (laser, exposure).
  int first_frame_ms = 3000;
  // Between attempts; opening takes a device about as long again.
  int retry_ms = 250;
};

}  // namespace fusion_slam
