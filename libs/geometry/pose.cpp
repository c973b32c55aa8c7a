#include "libs/geometry/pose.hpp"

#include <cmath>

namespace fusion_slam {

SE2 SE2::operator*(const SE2& other) const {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {x + c * other.x - s * other.y, y + s * other.x + c * other.y,
          wrap_angle(yaw + other.yaw)};
}

Eigen::Vector2d SE2::operator*(const Eigen::Vector2d& p) const {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {x + c * p.x() - s * p.y(), y + s * p.x() + c * p.y()};
}

SE2 SE2::inverse() const {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {-c * x - s * y, s * x - c * y, wrap_angle(-yaw)};
}

double wrap_angle(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2.0 * M_PI);
  return wrapped <= -M_PI ? wrapped + 2.0 * M_PI : wrapped;
}

Eigen::Vector3d log_so3(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2.0 * q.vec();
  return q.vec() * (2.0 * std::atan2(sine, q.w()) / sine);
}

Eigen::Matrix3d exp_so3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + skew(rotation_vector);
  return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

SE3 retract(const SE3& T, const Vector6d& xi) {
  SE3 step = SE3::Identity();
  step.linear() = exp_so3(xi.tail<3>());
  step.translation() = xi.head<3>();
  return T * step;
}

Vector6d local(const SE3& T, const SE3& other) {
  const SE3 step = T.inverse() * other;
  Vector6d xi;
  xi << step.translation(), log_so3(step.linear());
  return xi;
}

SE3 interpolate(const SE3& a, const SE3& b, double fraction) {
  SE3 result = SE3::Identity();
  result.translation() = (1.0 - fraction) * a.translation() + fraction * b.translation();
  const Eigen::Matrix3d relative = a.linear().transpose() * b.linear();
  result.linear() = a.linear() * exp_so3(fraction * log_so3(relative));
  return result;
}

SE3 make_pose(const Eigen::Vector3d& position_m, double w, double x, double y, double z) {
  Eigen::Quaterniond q(w, x, y, z);
  if (q.norm() < 1e-12) q = Eigen::Quaterniond::Identity();
  SE3 T = SE3::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = position_m;
  return T;
}

SE3 to_se3(const SE2& pose) { return from_xyz_rpy(pose.x, pose.y, 0.0, 0.0, 0.0, pose.yaw); }

SE2 to_se2(const SE3& pose) {
  return {pose.translation().x(), pose.translation().y(),
          std::atan2(pose.linear()(1, 0), pose.linear()(0, 0))};
}

SE3 from_xyz_rpy(double x, double y, double z, double roll, double pitch, double yaw) {
  SE3 T = SE3::Identity();
  T.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

Eigen::Matrix3d rotation_to_z(const Eigen::Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

SE3 levelling(const SE3& T_old_a, const SE3& T_new_a) {
  const Eigen::Vector3d up_a = T_new_a.linear().transpose() * Eigen::Vector3d::UnitZ();
  SE3 L = SE3::Identity();
  L.linear() = rotation_to_z(T_old_a.linear() * up_a);
  L.translation().z() = T_new_a.translation().z() - (L.linear() * T_old_a.translation()).z();
  return L;
}

Eigen::Matrix3d optical_to_body() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

}  // namespace fusion_slam
