// Exact depth images of a small room: floor z = 0, a wall at x = 2.5, and a box of 0.3 m on the
// floor before it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

inline CameraModel small_camera() {
  CameraModel camera;
  camera.width_px = 160;
  camera.height_px = 120;
  camera.fx_px = camera.fy_px = 131.0;
  camera.cx_px = 79.5;
  camera.cy_px = 59.5;
  return camera;
}

// Camera 0.35 m above the floor, looking ahead.
inline RobotModel robot_with_camera_at(double ahead_m) {
  RobotModel robot;
  robot.T_base_camera.linear() = optical_to_body();
  robot.T_base_camera.translation() = Eigen::Vector3d(ahead_m, 0.0, 0.35);
  return robot;
}

// Distance along the ray to the room, in multiples of `direction`.
inline double hit_room(const Eigen::Vector3d& from, const Eigen::Vector3d& direction,
                       bool with_box) {
  double t = std::numeric_limits<double>::infinity();
  if (direction.z() < 0.0) t = std::min(t, -from.z() / direction.z());
  if (direction.x() > 0.0) t = std::min(t, (2.5 - from.x()) / direction.x());
  const Eigen::Array3d low(1.5, -0.2, 0.0);
  const Eigen::Array3d high(1.8, 0.2, 0.3);
  const Eigen::Array3d a = (low - from.array()) / direction.array();
  const Eigen::Array3d b = (high - from.array()) / direction.array();
  const double enter = a.min(b).maxCoeff();
  const double leave = a.max(b).minCoeff();
  if (with_box && enter > 0.0 && enter < leave) t = std::min(t, enter);
  return t;
}

inline RgbdFrame render_room(const SE3& T_room_camera, const CameraModel& camera,
                             std::int64_t utime_us, bool with_box = true) {
  RgbdFrame frame;
  frame.utime_us = utime_us;
  frame.colour_bgr = cv::Mat(camera.height_px, camera.width_px, CV_8UC3, cv::Scalar(10, 20, 30));
  frame.depth_mm = cv::Mat::zeros(camera.height_px, camera.width_px, CV_16UC1);
  for (int v = 0; v < camera.height_px; ++v)
    for (int u = 0; u < camera.width_px; ++u) {
      const Eigen::Vector3d ray = T_room_camera.linear() * camera.unproject(u, v, 1.0);
      const double z_m = hit_room(T_room_camera.translation(), ray, with_box);
      if (z_m < 20.0)
        frame.depth_mm.at<std::uint16_t>(v, u) =
            static_cast<std::uint16_t>(std::lround(z_m * 1000));
    }
  return frame;
}

}  // namespace fusion_slam
