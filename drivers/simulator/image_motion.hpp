// How a picture moves while the camera does. From one rendered frame and the camera's speed, the
// frame a few milliseconds before or after: sampled back along each pixel's velocity
// (Longuet-Higgins & Prazdny 1980). True to a pixel or two of motion but at depth edges, where what
// is newly seen is not in the frame; a small price against rendering every instant.
#pragma once

#include <opencv2/core.hpp>

#include "libs/camera/camera_model.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// Velocity of the camera in its own (optical) axes.
struct CameraTwist {
  Eigen::Vector3d linear_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_rad_s = Eigen::Vector3d::Zero();
};

// From two poses dt_s apart.
CameraTwist twist_between(const SE3& T_world_camera_before, const SE3& T_world_camera_after,
                          double dt_s);

// Image velocity (px/s) of what pixel (u, v) shows at depth z_m; without depth (0) that of a point
// far away.
Eigen::Vector2d image_velocity(const CameraModel& camera, const CameraTwist& twist, double u_px,
                               double v_px, double z_m);

struct ShutterModel {
  double open_s = 0.0;     // each row integrates light for so long, around its time
  double readout_s = 0.0;  // the last row's time minus the first's; the middle row's is 0
};

// The frame that a shutter makes. colour: 0 to 255; depth_m: z of each pixel, 0 for none.
cv::Mat_<cv::Vec3f> expose_moving(const CameraModel& camera, const CameraTwist& twist,
                                  const ShutterModel& shutter, const cv::Mat_<cv::Vec3f>& colour,
                                  const cv::Mat_<float>& depth_m);

// depth_m as it is delay_s later.
cv::Mat_<float> depth_later(const CameraModel& camera, const CameraTwist& twist, double delay_s,
                            const cv::Mat_<float>& depth_m);

}  // namespace fusion_slam
