// One opened OpenNI2 device (or recording): its depth and colour streams, set up as we need them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <OniCAPI.h>
#include <opencv2/core.hpp>

#include "drivers/openni2_camera/config.hpp"
#include "drivers/openni2_camera/pixel_formats.hpp"
#include "drivers/openni2_camera/runtime.hpp"

namespace fusion_slam {

struct DeviceFrame {
  bool colour = false;
  std::int64_t device_us = 0;
  cv::Mat image;    // empty when it was not usable
  std::string why;  // it was not
};

struct FieldOfView {
  double x_rad = 0.0;  // 0: the device does not say
  double y_rad = 0.0;
};

// One thread.
class OpenniDevice {
 public:
  // Opens, chooses modes, turns mirroring off, sets registration and automatic exposure, starts.
  // Throws CameraError naming what the device can't do and what it can. The runtime must outlive
  // it.
  OpenniDevice(const OpenniRuntime& runtime, const CameraDriverConfig& config);
  ~OpenniDevice();
  OpenniDevice(const OpenniDevice&) = delete;
  OpenniDevice& operator=(const OpenniDevice&) = delete;

  // The next frame of either stream; nothing when none comes within wait_ms. Throws CameraError
  // when the stream broke.
  std::optional<DeviceFrame> read(int wait_ms);

  const std::string& name() const { return name_; }  // vendor, name and URI
  bool registers() const { return registers_; }      // the device moves depth into colour's view
  cv::Size depth_size() const { return {depth_.mode.resolutionX, depth_.mode.resolutionY}; }
  FieldOfView colour_fov() const { return fov(colour_); }
  FieldOfView depth_fov() const { return fov(depth_); }
  std::string modes() const;  // "640 x 480 at 30 Hz (RGB), depth ..."

 private:
  struct Stream {
    OniStreamHandle handle = nullptr;
    OniVideoMode mode{};
    PixelFormat format = PixelFormat::kRgb;
  };
  void open(const std::string& uri);
  void set_up(bool colour, const CameraDriverConfig& config);
  void set_registration(const CameraDriverConfig& config);
  void set_flag(const Stream& stream, int property, bool value) const;
  FieldOfView fov(const Stream& stream) const;
  void close();

  OniDeviceHandle device_ = nullptr;
  Stream colour_, depth_;
  std::string name_;
  bool registers_ = false;
};

}  // namespace fusion_slam
