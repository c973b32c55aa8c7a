#include "drivers/openni2_camera/uvc_camera.hpp"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <utility>

#include <unistd.h>

#include "drivers/openni2_camera/runtime.hpp"

namespace fusion_slam {
namespace {

// Values of V4L2_CID_EXPOSURE_AUTO, which OpenCV passes on: manual, aperture priority.
constexpr double kManual = 1.0;
constexpr double kAutomatic = 3.0;
constexpr std::int64_t kOldest_us = 500'000;  // a stamp further back than this is no stamp

std::int64_t steady_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

UvcCamera::UvcCamera(const CameraDriverConfig& config) {
  const std::string& path = config.connection.colour;
  std::error_code error;
  device_ = std::filesystem::is_character_file(path, error);
  if (!std::filesystem::exists(path, error))
    throw CameraError("there is no colour camera " + path +
                      ": plug it in, or name another one (v4l2-ctl --list-devices)");
  if (access(path.c_str(), R_OK) != 0)
    throw CameraError("no permission for " + path +
                      ": install config/udev/99-fusion-slam.rules, or adduser NAME video");
  if (!capture_.open(path, device_ ? cv::CAP_V4L2 : cv::CAP_ANY))
    throw CameraError(path + " can't be opened as a camera: is it in use by another program?");
  const CameraModel& model = config.camera;
  if (device_) {
    capture_.set(cv::CAP_PROP_FOURCC, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'));
    capture_.set(cv::CAP_PROP_FRAME_WIDTH, model.width_px);
    capture_.set(cv::CAP_PROP_FRAME_HEIGHT, model.height_px);
    capture_.set(cv::CAP_PROP_FPS, model.rate_hz);
    capture_.set(cv::CAP_PROP_BUFFERSIZE, 2);
    capture_.set(cv::CAP_PROP_AUTO_EXPOSURE,
                 config.connection.auto_exposure ? kAutomatic : kManual);
  }
  const auto width = static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH));
  const auto height = static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT));
  if (width != model.width_px || height != model.height_px)
    throw CameraError(path + " gives " + std::to_string(width) + " x " + std::to_string(height) +
                      " and not " + std::to_string(model.width_px) + " x " +
                      std::to_string(model.height_px) + ": change the size in the camera's file");
  const double rate_hz = capture_.get(cv::CAP_PROP_FPS);
  thread_ = std::thread([this, rate_hz] { read(1.0 / (rate_hz > 0.0 ? rate_hz : 30.0)); });
}

UvcCamera::~UvcCamera() {
  stop_ = true;
  thread_.join();
}

// V4L2 stamps buffers by CLOCK_MONOTONIC, which is our steady clock.
std::int64_t UvcCamera::stamp_us(std::int64_t arrival_us) const {
  if (!device_) return arrival_us;
  const std::int64_t stamp = std::llround(1e3 * capture_.get(cv::CAP_PROP_POS_MSEC));
  return stamp > arrival_us - kOldest_us && stamp <= arrival_us ? stamp : arrival_us;
}

void UvcCamera::read(double period_s) {
  auto due = std::chrono::steady_clock::now();
  cv::Mat image;
  while (!stop_) {
    if (!capture_.grab() || !capture_.retrieve(image) || image.type() != CV_8UC3) {
      broken_ = true;
      return;
    }
    if (!device_) {
      due += std::chrono::microseconds(std::llround(1e6 * period_s));
      std::this_thread::sleep_until(due);
    }
    TimedImage taken{stamp_us(steady_us()), image.clone(), 0};
    const std::lock_guard<std::mutex> lock(mutex_);
    newest_ = std::move(taken);
  }
}

std::optional<TimedImage> UvcCamera::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(newest_, std::nullopt);
}

}  // namespace fusion_slam
