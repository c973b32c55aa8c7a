// Depth for features, and their ideal pixels.
#pragma once

#include <opencv2/core.hpp>

#include "libs/camera/camera_model.hpp"
#include "libs/features/feature.hpp"

namespace fusion_slam {

// Depth (m) at a pixel of a registered CV_16UC1 depth image (mm, 0: none): the median of the valid
// readings among its 3 x 3 neighbours. 0 when fewer than 4 are valid or when they lie on both sides
// of a depth edge (spread over what noise and a steep surface explain), for a corner on an edge
// belongs to either side by chance.
double depth_at(const cv::Mat& depth_mm, const CameraModel& camera, double u_px, double v_px);

// Fills depth_m and depth_sigma_m of features whose pixels are as the camera took them.
void attach_depth(const cv::Mat& depth_mm, const CameraModel& camera, FeatureSet* set);

// Moves pixels as the camera took them to where a lens without distortion would show them. Nothing
// without distortion.
void undistort(const CameraModel& camera, FeatureSet* set);

}  // namespace fusion_slam
