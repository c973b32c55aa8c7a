#include "libs/pose_manifold/pose_manifold.hpp"

#include <algorithm>

namespace fusion_slam {

PoseBlock to_block(const SE3& T) {
  const Eigen::Quaterniond q(T.linear());
  const Eigen::Vector3d t = T.translation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

SE3 from_block(const double* block) {
  return make_pose({block[0], block[1], block[2]}, block[6], block[3], block[4], block[5]);
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const PoseBlock moved = to_block(retract(from_block(x), Eigen::Map<const Vector6d>(delta)));
  std::copy(moved.begin(), moved.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* /*x*/, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>>(jacobian).setIdentity();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Vector6d> difference(y_minus_x);
  difference = local(from_block(x), from_block(y));
  return true;
}

bool PoseManifold::MinusJacobian(const double* /*x*/, double* jacobian) const {
  Eigen::Map<PoseBlockJacobian<6>>(jacobian).setIdentity();
  return true;
}

}  // namespace fusion_slam
