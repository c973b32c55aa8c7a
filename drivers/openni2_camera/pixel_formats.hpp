// A device's images as ours. Pure; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include <opencv2/core.hpp>

namespace fusion_slam {

// The formats of OpenNI2 that cameras send and we read.
enum class PixelFormat { kRgb, kUyvy, kYuyv, kGrey, kJpeg, kDepthMm, kDepth100um };

// An image where the runtime has it; nothing is owned.
struct RawImage {
  PixelFormat format = PixelFormat::kRgb;
  int width_px = 0;
  int height_px = 0;
  int stride_bytes = 0;  // a row; 0: no gaps
  const std::uint8_t* bytes = nullptr;
  std::size_t size_bytes = 0;
};

// CV_8UC3 (BGR) or, for depth, CV_16UC1 (mm, 0: none; 100 um units are rounded to the nearest mm,
// halves up). Nothing, with a reason in `why`, when the image is not of the size that the mode
// promised, or has fewer bytes than its size needs.
std::optional<cv::Mat> read_image(const RawImage& raw, cv::Size promised, std::string* why);

}  // namespace fusion_slam
