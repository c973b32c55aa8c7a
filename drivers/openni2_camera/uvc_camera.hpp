// Colour from a UVC camera (Astra models whose colour is one) through V4L2, or from a video file at
// its own pace (tests). A thread of its own reads; only the newest image waits.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <opencv2/videoio.hpp>

#include "drivers/openni2_camera/config.hpp"
#include "drivers/openni2_camera/frame_pairer.hpp"

namespace fusion_slam {

class UvcCamera {
 public:
  // Opens connection.colour with the camera model's size and rate. Throws CameraError: no such
  // device, no permission, another size.
  explicit UvcCamera(const CameraDriverConfig& config);
  ~UvcCamera();
  UvcCamera(const UvcCamera&) = delete;
  UvcCamera& operator=(const UvcCamera&) = delete;

  // The newest image since the last take(), its time in us of the steady clock.
  std::optional<TimedImage> take();
  bool broken() const { return broken_; }  // reading failed: it was unplugged (or the file ended)

 private:
  void read(double period_s);
  std::int64_t stamp_us(std::int64_t arrival_us) const;

  cv::VideoCapture capture_;
  bool device_ = true;
  std::mutex mutex_;
  std::optional<TimedImage> newest_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> broken_{false};
  std::thread thread_;
};

}  // namespace fusion_slam
