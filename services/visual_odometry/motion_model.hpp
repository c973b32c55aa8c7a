// Constant velocity: between two frames a hand or a robot keeps moving as it did.
#pragma once

#include <cstdint>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

class MotionModel {
 public:
  // Where the camera is at utime if it keeps its velocity; the last pose when too long ago or
  // unknown.
  SE3 predict(std::int64_t utime_us) const;
  void update(std::int64_t utime_us, const SE3& T_odom_camera);
  // After a loss: the velocity is unknown until two more poses are, and the prediction is this
  // pose.
  void restart(const SE3& T_odom_camera);
  // The map under the camera was moved.
  void move(const SE3& T_new_old) { T_odom_camera_ = T_new_old * T_odom_camera_; }
  // Per second, translation (m) then rotation (rad), camera axes; zero when unknown.
  Vector6d velocity() const { return moving_ ? velocity_ : Vector6d::Zero(); }

 private:
  SE3 T_odom_camera_ = SE3::Identity();
  Vector6d velocity_ = Vector6d::Zero();  // per second, in the camera's axes
  std::int64_t utime_us_ = 0;
  bool moving_ = false;
};

}  // namespace fusion_slam
