// One RGB-D frame in memory.
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

namespace fusion_slam {

struct RgbdFrame {
  std::int64_t utime_us = 0;  // time of the colour exposure
  cv::Mat colour_bgr;         // CV_8UC3, height x width
  cv::Mat depth_mm;           // CV_16UC1, same size, registered to colour; 0: no depth
};

}  // namespace fusion_slam
