#include "tests/bench/visual_odometry/standing.hpp"

#include <cmath>
#include <fstream>

#include <unistd.h>

namespace fusion_slam {
namespace {

constexpr double kColourSigma = 2.5;

RgbdFrame seen_again(const RgbdFrame& frame, const CameraModel& camera, cv::RNG* random) {
  RgbdFrame again;
  cv::Mat noise(frame.colour_bgr.size(), CV_16SC3);
  random->fill(noise, cv::RNG::NORMAL, 0.0, kColourSigma);
  cv::add(frame.colour_bgr, noise, again.colour_bgr, cv::noArray(), CV_8UC3);
  cv::Mat normal(frame.depth_mm.size(), CV_32FC1);
  random->fill(normal, cv::RNG::NORMAL, 0.0, 1.0);
  again.depth_mm = frame.depth_mm.clone();
  for (int y = 0; y < again.depth_mm.rows; ++y)
    for (int x = 0; x < again.depth_mm.cols; ++x) {
      std::uint16_t& mm = again.depth_mm.at<std::uint16_t>(y, x);
      if (mm == 0) continue;
      const double sigma_mm = 1e3 * camera.depth_sigma(mm * 1e-3);
      mm = cv::saturate_cast<std::uint16_t>(mm + sigma_mm * normal.at<float>(y, x));
    }
  return again;
}

}  // namespace

void stand_still(const RgbdFrame& frame, const CameraModel& camera, double minutes, double hz,
                 const std::function<void(const RgbdFrame&)>& show,
                 const std::function<void(int minute)>& minute) {
  cv::RNG random(1);
  const int n = static_cast<int>(std::lround(minutes * 60.0 * hz));
  int told = 0;
  for (int i = 1; i <= n; ++i) {
    RgbdFrame again = seen_again(frame, camera, &random);
    again.utime_us = frame.utime_us + static_cast<std::int64_t>(std::llround(i * 1e6 / hz));
    show(again);
    const int passed = static_cast<int>(i / hz / 60.0);
    if (passed > told) minute(told = passed);
  }
}

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  double resident = 0.0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1048576.0;
}

}  // namespace fusion_slam
