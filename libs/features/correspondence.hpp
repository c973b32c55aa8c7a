// A known 3D point and where the camera sees it now.
#pragma once

#include <Eigen/Core>

namespace fusion_slam {

struct Correspondence {
  Eigen::Vector3d p_reference = Eigen::Vector3d::Zero();  // m, in whatever frame the pose is wanted
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();        // ideal pixel in this image
  double pixel_sigma = 1.0;                               // px, grows with the octave
  double depth_m = 0.0;                                   // measured in this image; 0: none
  double depth_sigma_m = 0.0;
};

}  // namespace fusion_slam
