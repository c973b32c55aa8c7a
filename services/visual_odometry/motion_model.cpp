#include "services/visual_odometry/motion_model.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kHorizon_us = 300'000;  // a hand's velocity says nothing about later

}  // namespace

SE3 MotionModel::predict(std::int64_t utime_us) const {
  const std::int64_t dt_us = utime_us - utime_us_;
  if (!moving_ || dt_us <= 0 || dt_us > kHorizon_us) return T_odom_camera_;
  return retract(T_odom_camera_, velocity_ * (dt_us * 1e-6));
}

void MotionModel::update(std::int64_t utime_us, const SE3& T_odom_camera) {
  const std::int64_t dt_us = utime_us - utime_us_;
  moving_ = utime_us_ != 0 && dt_us > 0 && dt_us <= kHorizon_us;
  if (moving_) velocity_ = local(T_odom_camera_, T_odom_camera) / (dt_us * 1e-6);
  T_odom_camera_ = T_odom_camera;
  utime_us_ = utime_us;
}

void MotionModel::restart(const SE3& T_odom_camera) {
  moving_ = false;
  T_odom_camera_ = T_odom_camera;
  utime_us_ = 0;
}

}  // namespace fusion_slam
