#include "libs/pose_manifold/relative_pose_cost.hpp"

#include <cmath>

namespace fusion_slam {
namespace {

// d log(R Exp(d)) / d d at d = 0, with v = log(R).
Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const Eigen::Matrix3d V = skew(v);
  if (angle < 1e-5) return Eigen::Matrix3d::Identity() + 0.5 * V + V * V / 12.0;
  const double c = 1.0 / (angle * angle) - 1.0 / (2.0 * angle * std::tan(0.5 * angle));
  return Eigen::Matrix3d::Identity() + 0.5 * V + c * V * V;
}

}  // namespace

// With P = T_from^-1 T_to and E = M^-1 P (M measured), error (t_E, log R_E):
//   to   -> to * Exp(d):   t_E += R_E dt,              log += Jr^-1 dr
//   from -> from * Exp(d): t_E += R_M^T (-dt + [t_P] dr), log -= Jr^-1 R_P^T dr
Vector6d relative_pose_error(const SE3& T_from, const SE3& T_to, const SE3& T_from_to,
                             Matrix6d* J_from, Matrix6d* J_to) {
  const SE3 P = T_from.inverse() * T_to;
  const SE3 E = T_from_to.inverse() * P;
  Vector6d error;
  error << E.translation(), log_so3(E.linear());
  if (J_from == nullptr || J_to == nullptr) return error;
  const Eigen::Matrix3d Jr_inv = right_jacobian_inverse(error.tail<3>());
  const Eigen::Matrix3d R_m_t = T_from_to.linear().transpose();
  J_from->setZero();
  J_from->topLeftCorner<3, 3>() = -R_m_t;
  J_from->topRightCorner<3, 3>() = R_m_t * skew(P.translation());
  J_from->bottomRightCorner<3, 3>() = -Jr_inv * P.linear().transpose();
  J_to->setZero();
  J_to->topLeftCorner<3, 3>() = E.linear();
  J_to->bottomRightCorner<3, 3>() = Jr_inv;
  return error;
}

bool RelativePoseCost::Evaluate(const double* const* parameters, double* residuals,
                                double** jacobians) const {
  Matrix6d J_from, J_to;
  const Vector6d error = relative_pose_error(from_block(parameters[0]), from_block(parameters[1]),
                                             T_from_to_, &J_from, &J_to);
  Eigen::Map<Vector6d>{residuals} = sqrt_information_ * error;
  if (jacobians == nullptr) return true;
  const Matrix6d* J[2] = {&J_from, &J_to};
  for (int i = 0; i < 2; ++i)
    if (jacobians[i] != nullptr) to_block_jacobian<6>(sqrt_information_ * *J[i], jacobians[i]);
  return true;
}

}  // namespace fusion_slam
