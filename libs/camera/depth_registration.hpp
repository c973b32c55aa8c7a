// Depth images seen from the colour camera. Pure; any thread.
#pragma once

#include <opencv2/core.hpp>

#include "libs/camera/camera_model.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// Two pinhole cameras in one housing; distortion of either is not looked at.
struct DepthRegistration {
  CameraModel depth_camera;
  CameraModel colour_camera;
  SE3 T_colour_depth = SE3::Identity();
};

// depth_mm (CV_16UC1, the depth camera's size; 0: no depth) as the colour camera would measure it:
// CV_16UC1 of the colour camera's size, mm along the colour camera's axis. Each depth pixel is a
// small plate that covers the square of its own pixel at its own depth; a colour pixel takes the
// nearest plate over its centre. So magnification leaves no holes, a near object hides what is
// behind it, and its edge grows by half a depth pixel at most. Throws std::invalid_argument when
// the image's type or size is not the depth camera's.
cv::Mat register_depth(const cv::Mat& depth_mm, const DepthRegistration& registration);

}  // namespace fusion_slam
