// Depth images as calibration wants them. Pure; any thread.
#pragma once

#include <opencv2/core.hpp>

#include "libs/calibration/drive.hpp"

namespace fusion_slam {

class DepthSampler {
 public:
  explicit DepthSampler(const CameraModel& camera);

  // Every fourth pixel of every fourth column (CV_16UC1, mm, the camera's size) that lies on a
  // smooth surface: the second difference of inverse depth, zero on any plane, within three sigmas
  // along both axes. Distortion removed. No columns when the image is not of the camera's size.
  DepthFrame sample(std::int64_t utime_us, const cv::Mat& depth_mm) const;

 private:
  CameraModel camera_;
  std::vector<cv::Point2d> rays_;  // of the sampled pixels, column by column
};

}  // namespace fusion_slam
