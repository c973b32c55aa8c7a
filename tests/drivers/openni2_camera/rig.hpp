// A driver on the virtual device in the real OpenNI2 runtime, and a diary of what it says and
// gives. The scene: a textured wall 2 m away and a box 1 m away, seen by two cameras 25 mm apart.
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

#include "drivers/openni2_camera/driver.hpp"
#include "tests/support/virtual_openni2/feed.hpp"

namespace fusion_slam {

struct RigScene {
  cv::Mat colour_bgr, depth_mm, registered_mm;
};
constexpr double kRigBaseline_m = 0.025;  // the depth camera sits to the right of colour
RigScene rig_scene(const FeedFormat& format);

// A small picture: the sanitizers are slow.
FeedFormat rig_format();

class CameraRig {
 public:
  struct Entry {
    std::chrono::steady_clock::time_point when;
    std::string text;  // empty: a pair
    bool frames = false;
    FramePair pair;
  };
  using Diary = std::vector<Entry>;

  explicit CameraRig(const FeedFormat& format = rig_format());
  ~CameraRig();
  CameraRig(const CameraRig&) = delete;
  CameraRig& operator=(const CameraRig&) = delete;

  void plug_in();  // the device, and a thread that gives it frames at its rate
  void unplug();   // for good: its file goes
  void start();    // the driver
  void stop();

  FeedWriter& feed() { return *feed_; }
  CameraDriver& driver() { return *driver_; }
  CameraDriverConfig& config() { return config_; }
  const RigScene& scene() const { return scene_; }
  const std::filesystem::path& folder() const { return folder_; }
  std::atomic<int>& depth_lag_us() { return depth_lag_us_; }
  std::optional<CameraSetup> setup() const;
  bool ended() const { return ended_; }

  // Waits for something to be true of the diary, 30 s at most (it never takes that long unless
  // something is wrong).
  bool wait(const std::function<bool(const Diary&)>& done);
  bool wait_for_text(const std::string& part, std::size_t from = 0);
  bool wait_for_pairs(int n, std::size_t from = 0);
  Diary diary() const;
  std::size_t now() const { return diary().size(); }

 private:
  void add(Entry entry);
  void give_frames();

  FeedFormat format_;
  RigScene scene_;
  std::filesystem::path folder_;
  CameraDriverConfig config_;
  std::atomic<int> depth_lag_us_{3000};

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Diary diary_;
  std::optional<CameraSetup> setup_;
  std::atomic<bool> ended_{false};

  std::unique_ptr<FeedWriter> feed_;
  std::atomic<bool> feeding_{false};
  std::thread feeder_;
  std::unique_ptr<CameraDriver> driver_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace fusion_slam
