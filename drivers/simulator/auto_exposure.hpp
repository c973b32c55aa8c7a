// Automatic exposure: steers the mean grey value to a target, as a UVC camera's firmware does, and
// always a few frames late. Frames may be rendered by several threads at once and each needs what
// the ones before it showed; so who renders frame i tells its brightness and may wait for others'.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>

#include "drivers/simulator/camera_noise.hpp"

namespace fusion_slam {

class AutoExposure {
 public:
  static constexpr std::int64_t kLateFrames = 2;  // the firmware's own delay

  AutoExposure(const CameraNoise& noise, double frame_period_s);

  // Mean grey value of frame `index` at factor 1, or nothing when nobody rendered it. Every index
  // from 0 on must be told once, in any order. Any thread.
  void tell(std::int64_t index, std::optional<double> mean_grey);

  // The factor for frame `index`; waits until all frames up to index - kLateFrames, and the first
  // one, are told (the first is as if the camera had long looked at it). Frames must be begun in
  // order, so that whom one waits for is at work. Any thread. While automatic exposure is off, the
  // constant factor at once.
  double factor(std::int64_t index);

  // Ends all waiting; factors are then meaningless.
  void cancel();

 private:
  double wished(double mean_grey) const;

  CameraNoise noise_;
  double blend_;  // share of the way to the wished factor that one frame goes
  std::mutex mutex_;
  std::condition_variable changed_;
  bool cancelled_ = false;
  std::map<std::int64_t, std::optional<double>> told_;
  std::map<std::int64_t, double> after_;  // factor in force once frame i has been seen
};

}  // namespace fusion_slam
