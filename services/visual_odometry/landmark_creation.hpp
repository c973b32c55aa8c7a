// What a new keyframe adds to the map: observations of what was tracked, new landmarks from depth.
#pragma once

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

struct SeenLandmark {
  std::int64_t landmark = 0;
  int feature = 0;
};

// Adds the keyframe, links its features to the landmarks they were matched to (whose look is
// renewed) and makes a landmark of every other feature with depth. Features without depth stay
// bearing-only: triangulation and fusion may give them a landmark later. Returns the new landmarks'
// ids, ascending.
std::vector<std::int64_t> insert_keyframe(MapKeyframe keyframe, const CameraModel& camera,
                                          const std::vector<SeenLandmark>& seen,
                                          const std::vector<double>& scale_of_octave,
                                          double pixel_sigma, VisualMap* map);

// Information (inverse covariance, 1/m^2) in odom of a point measured by one RGB-D observation:
// along the ray the depth's noise, across it the pixel's.
Eigen::Matrix3d observation_information(const CameraModel& camera, const SE3& T_odom_camera,
                                        const Eigen::Vector3d& p_camera, double pixel_sigma_px,
                                        double depth_sigma_m);

}  // namespace fusion_slam
