// Decodes frames and finds their features on a thread of its own, while tracking is still at the
// frame before: neither depends on anything that tracking knows, so results are the same with it
// and without. For replays, which know the next frame before it is its turn.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/features/orb_extractor.hpp"

namespace fusion_slam {

struct SeenFrame {
  RgbdFrame frame;
  FeatureSet features;  // with depth, where a lens without distortion would show them
};

// Features of a frame of the camera's size: ORB, their depth, distortion taken out. Pure.
FeatureSet find_features(const OrbExtractor& extractor, const CameraModel& camera,
                         const RgbdFrame& frame);

// Colour is CV_8UC3, depth CV_16UC1, and both are of the camera's size.
bool has_form(const RgbdFrame& frame, const CameraModel& camera);

// Thread-safe.
class FramesAhead {
 public:
  using Decode = std::function<std::optional<RgbdFrame>()>;

  FramesAhead(const CameraModel& camera, const OrbConfig& config);
  ~FramesAhead();
  FramesAhead(const FramesAhead&) = delete;
  FramesAhead& operator=(const FramesAhead&) = delete;

  // `decode` will be called on the thread, if at all: with 8 frames waiting nothing is begun.
  void begin(std::int64_t utime_us, Decode decode);

  // Waits for a frame that is at work. Nothing when it isn't begun, or can't be decoded: the caller
  // then does it himself. Frames that were begun before it are forgotten.
  std::optional<SeenFrame> take(std::int64_t utime_us);

 private:
  enum class State { kWaiting, kAtWork, kDone };
  struct Job {
    std::int64_t utime_us = 0;
    Decode decode;
    State state = State::kWaiting;
    std::optional<SeenFrame> seen;
  };
  void work();
  std::optional<SeenFrame> see(const Decode& decode) const;

  CameraModel camera_;
  OrbExtractor extractor_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Job>> jobs_;
  bool stopping_ = false;
  std::thread thread_;  // last: starts when all else is there
};

}  // namespace fusion_slam
