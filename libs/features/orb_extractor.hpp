// ORB features spread evenly over an image and its scale pyramid.
// Sources: Rosten & Drummond 2006 (FAST); Rublee et al. 2011 (orientation by intensity centroid,
// rBRIEF, by OpenCV); Mur-Artal et al. 2015, section V-A (why features must be spread: tracking
// fails where they cluster).
#pragma once

#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>

#include "libs/features/feature.hpp"

namespace fusion_slam {

struct OrbConfig {
  int n_features = 1000;
  int n_levels = 8;
  double scale_factor = 1.2;   // between two levels: 8 levels span a factor of 3.6 in distance
  int fast_threshold = 20;     // grey levels; what is used where there is texture
  int fast_threshold_low = 5;  // where a cell has no corner at the threshold above: twice the
                               // noise of a cheap camera
  bool sub_pixel = false;      // corners to fractions of a pixel of their level
};

class OrbExtractor {
 public:
  explicit OrbExtractor(const OrbConfig& config = {});

  // Features of a CV_8UC1 image, octave by octave, at most about n_features. Positions are in the
  // pixels of `grey`, lens distortion included; depth is not filled in. Same input, same output, on
  // any number of threads.
  FeatureSet extract(const cv::Mat& grey) const;

  // Size of one pixel of this octave in pixels of the full image; the standard deviation of a
  // position is about this.
  double scale(int octave) const;

 private:
  std::vector<cv::KeyPoint> corners(const cv::Mat& level, int quota) const;

  OrbConfig config_;
  std::vector<double> scales_;
  std::vector<int> quotas_;
};

}  // namespace fusion_slam
