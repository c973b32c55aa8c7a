// FAST corners (Rosten & Drummond 2006) spread evenly over an image (Mur-Artal et al. 2015, section
// V-A).
#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace fusion_slam {

// At most `quota` corners of a CV_8UC1 image, at whole pixels, 3 from its border at least: first
// the strongest of each cell, then the second of each, and so on; cells are so large that a fully
// textured image fills its quota with 4 of each. Below the FAST threshold `usual` (grey levels),
// down to `low`, only the strongest of a cell that has none above. Pure.
std::vector<cv::KeyPoint> spread_corners(const cv::Mat& image, int quota, int usual, int low);

}  // namespace fusion_slam
