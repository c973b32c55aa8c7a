#include "services/lidar_mapper/pose_filter.hpp"

namespace fusion_slam {

Eigen::Matrix3d carry_error(const SE2& T_from_to) {
  const SE2 T = T_from_to.inverse();
  Eigen::Matrix3d ad = Eigen::Matrix3d::Identity();
  ad.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T.yaw).toRotationMatrix();
  ad(0, 2) = T.y;
  ad(1, 2) = -T.x;
  return ad;
}

void PoseFilter::predict(const SE2& motion, const Eigen::Matrix3d& noise) {
  Matrix6d F = Matrix6d::Identity();
  F.bottomRightCorner<3, 3>() = carry_error(motion);
  joint_ = F * joint_ * F.transpose();
  joint_.bottomRightCorner<3, 3>() += noise;
}

void PoseFilter::update(const Eigen::Matrix3d& information) {
  // (P + R)^-1 without R = information^-1, which need not exist: L - L (P^-1 + L)^-1 L, and
  // (P^-1 + L)^-1 = P (I + L P)^-1.
  const Eigen::Matrix3d P = covariance();
  const Eigen::Matrix3d posterior = P * (Eigen::Matrix3d::Identity() + information * P).inverse();
  const Eigen::Matrix3d W = information - information * posterior * information;
  const Eigen::Matrix<double, 6, 3> cross = joint_.rightCols<3>();
  joint_ -= cross * W * cross.transpose();
  joint_ = 0.5 * (joint_ + joint_.transpose()).eval();
}

void PoseFilter::clone() {
  const Eigen::Matrix3d P = covariance();
  joint_ << P, P, P, P;
}

Eigen::Matrix3d PoseFilter::since_node(const SE2& T_node_now) const {
  Eigen::Matrix<double, 3, 6> J;
  J << -carry_error(T_node_now), Eigen::Matrix3d::Identity();
  return J * joint_ * J.transpose();
}

}  // namespace fusion_slam
