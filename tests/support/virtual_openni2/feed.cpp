#include "tests/support/virtual_openni2/feed.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <opencv2/imgproc.hpp>
#include <sys/mman.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

float fov_rad(int size_px, double f_px) {
  return static_cast<float>(2.0 * std::atan(0.5 * size_px / f_px));
}

}  // namespace

const char* to_string(CameraFault fault) {
  constexpr const char* kNames[] = {"none",         "unplug",        "stall",
                                    "stall-colour", "stall-depth",   "corrupt",
                                    "wrong-size",   "clock-restart", "busy"};
  return kNames[static_cast<std::size_t>(fault)];
}

const std::vector<CameraFault>& camera_faults() {
  static const std::vector<CameraFault> all = {CameraFault::kUnplug,       CameraFault::kStall,
                                               CameraFault::kStallColour,  CameraFault::kStallDepth,
                                               CameraFault::kCorrupt,      CameraFault::kWrongSize,
                                               CameraFault::kClockRestart, CameraFault::kBusy};
  return all;
}

std::size_t slot_bytes(int width_px, int height_px) {
  const auto pixels = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  return (sizeof(FeedSlot) + 7 * pixels + 63) / 64 * 64;
}

std::size_t feed_bytes(int width_px, int height_px) {
  return sizeof(FeedHeader) + kFeedSlots * slot_bytes(width_px, height_px);
}

FeedWriter::FeedWriter(std::filesystem::path path, const FeedFormat& format)
    : path_(std::move(path)),
      format_(format),
      size_bytes_(feed_bytes(format.width_px, format.height_px)) {
  const auto fail = [&](const std::string& doing) {
    throw std::runtime_error("cannot " + doing + " " + path_.string() + ": " +
                             std::strerror(errno));
  };
  const std::string partial = path_.string() + ".partial";
  const int file = open(partial.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0) fail("make");
  void* memory = MAP_FAILED;
  if (ftruncate(file, static_cast<off_t>(size_bytes_)) == 0)
    memory = mmap(nullptr, size_bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (memory == MAP_FAILED) fail("map");
  header_ = static_cast<FeedHeader*>(memory);  // zeros: every atomic is valid
  header_->width_px = format.width_px;
  header_->height_px = format.height_px;
  header_->rate_hz = format.rate_hz;
  header_->can_register = format.can_register ? 1 : 0;
  header_->colour_fov_x_rad = fov_rad(format.width_px, format.colour_fx_px);
  header_->colour_fov_y_rad = fov_rad(format.height_px, format.colour_fy_px);
  header_->depth_fov_x_rad = fov_rad(format.width_px, format.depth_fx_px);
  header_->depth_fov_y_rad = fov_rad(format.height_px, format.depth_fy_px);
  header_->mirrored = 1;
  header_->magic = kFeedMagic;
  std::filesystem::rename(partial, path_);
}

FeedWriter::~FeedWriter() {
  header_->fault = static_cast<std::uint32_t>(CameraFault::kUnplug);
  munmap(header_, size_bytes_);
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void FeedWriter::set_fault(CameraFault fault) {
  header_->fault = static_cast<std::uint32_t>(fault);
}

void FeedWriter::write(std::uint64_t colour_us, std::uint64_t depth_us, const cv::Mat& colour_bgr,
                       const cv::Mat& depth_mm, const cv::Mat& registered_mm) {
  const cv::Size size(format_.width_px, format_.height_px);
  if (colour_bgr.size() != size || colour_bgr.type() != CV_8UC3 || depth_mm.size() != size ||
      depth_mm.type() != CV_16UC1 || registered_mm.size() != size ||
      registered_mm.type() != CV_16UC1)
    throw std::invalid_argument("FeedWriter: an image is not what the format says");
  const std::uint64_t number = header_->written + 1;
  auto* bytes = reinterpret_cast<std::uint8_t*>(header_) + sizeof(FeedHeader) +
                (number % kFeedSlots) * slot_bytes(size.width, size.height);
  auto* slot = reinterpret_cast<FeedSlot*>(bytes);
  slot->number = 0;
  slot->colour_us = colour_us;
  slot->depth_us = depth_us;
  std::uint8_t* pixels = bytes + sizeof(FeedSlot);
  cv::Mat rgb(size, CV_8UC3, pixels);
  cv::cvtColor(colour_bgr, rgb, cv::COLOR_BGR2RGB);
  cv::Mat depth(size, CV_16UC1, pixels + 3 * static_cast<std::size_t>(size.area()));
  depth_mm.copyTo(depth);
  cv::Mat registered(size, CV_16UC1, pixels + 5 * static_cast<std::size_t>(size.area()));
  registered_mm.copyTo(registered);
  slot->number = number;
  header_->written = number;
}

}  // namespace fusion_slam
