// What the virtual OpenNI2 device sees: a file in shared memory, written by a feeder (a test, or
// the program virtual_openni2) and read by the driver plug-in, which may live in another process.
//   FeedHeader | kFeedSlots slots of FeedSlot, colour (RGB888), depth, depth as the colour camera
//   sees it (both uint16 mm)
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace fusion_slam {

// The plug-in looks for the feed's path here.
inline constexpr const char* kFeedVariable = "FUSION_SLAM_VIRTUAL_CAMERA";
inline constexpr std::uint32_t kFeedMagic = 0x4653'4F32;  // "FSO2"
inline constexpr std::uint64_t kFeedSlots = 6;

enum class CameraFault : std::uint32_t {
  kNone,
  kUnplug,        // the device leaves the list, its streams fall silent
  kStall,         // it stays in the list and sends nothing
  kStallColour,   // only depth comes
  kStallDepth,    // only colour comes
  kCorrupt,       // frames hold fewer bytes than their size needs
  kWrongSize,     // frames are half as wide as the mode says
  kClockRestart,  // the device's clock begins at 0 again, once
  kBusy,          // the device can't be opened (another program has it)
};
const char* to_string(CameraFault fault);
const std::vector<CameraFault>& camera_faults();  // without kNone

struct FeedHeader {
  std::atomic<std::uint32_t> magic;  // written last
  std::atomic<std::uint32_t> fault;
  std::atomic<std::uint64_t> written;  // frames so far; frame n is in slot n % kFeedSlots
  // What the driver set, for the tests.
  std::atomic<std::uint32_t> mirrored;
  std::atomic<std::uint32_t> registered;
  std::atomic<std::uint32_t> auto_exposure;
  std::atomic<std::uint32_t> opened;  // times
  std::int32_t width_px, height_px, rate_hz;
  std::int32_t can_register;  // the device can move depth into the colour camera
  float colour_fov_x_rad, colour_fov_y_rad, depth_fov_x_rad, depth_fov_y_rad;
};

struct FeedSlot {
  std::atomic<std::uint64_t> number;  // 1, 2 ...; 0 while it is being written
  std::uint64_t colour_us, depth_us;  // the device's clock
};

struct FeedFormat {
  int width_px = 640;
  int height_px = 480;
  int rate_hz = 30;
  bool can_register = true;
  double colour_fx_px = 570.0;
  double colour_fy_px = 570.0;
  double depth_fx_px = 570.0;
  double depth_fy_px = 570.0;
};

std::size_t feed_bytes(int width_px, int height_px);
std::size_t slot_bytes(int width_px, int height_px);

// Makes the file and writes it. One thread.
class FeedWriter {
 public:
  FeedWriter(std::filesystem::path path, const FeedFormat& format);  // throws std::runtime_error
  ~FeedWriter();  // removes the file: the device is gone
  FeedWriter(const FeedWriter&) = delete;
  FeedWriter& operator=(const FeedWriter&) = delete;

  // colour CV_8UC3 (BGR), depth CV_16UC1, all of the format's size; stamps of the device's clock.
  void write(std::uint64_t colour_us, std::uint64_t depth_us, const cv::Mat& colour_bgr,
             const cv::Mat& depth_mm, const cv::Mat& registered_mm);
  void set_fault(CameraFault fault);  // any thread
  const FeedHeader& header() const { return *header_; }

 private:
  std::filesystem::path path_;
  FeedFormat format_;
  FeedHeader* header_ = nullptr;
  std::size_t size_bytes_ = 0;
};

}  // namespace fusion_slam
