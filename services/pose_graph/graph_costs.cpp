#include "services/pose_graph/graph_costs.hpp"

#include <cmath>

#include <Eigen/Cholesky>

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

Eigen::Vector3d planar_residual(double sigma_z_m, double sigma_tilt_rad, const SE3& T_map_base,
                                Eigen::Matrix<double, 3, 6>* J) {
  const Eigen::Matrix3d R = T_map_base.linear();
  if (J != nullptr) {
    J->setZero();
    J->block<1, 3>(0, 0) = R.row(2) / sigma_z_m;
    const Eigen::Matrix3d d_up = -R * skew(Eigen::Vector3d::UnitZ());
    J->block<2, 3>(1, 3) = d_up.topRows<2>() / sigma_tilt_rad;
  }
  return {T_map_base.translation().z() / sigma_z_m, R(0, 2) / sigma_tilt_rad,
          R(1, 2) / sigma_tilt_rad};
}

bool PlanarCost::Evaluate(const double* const* parameters, double* residuals,
                          double** jacobians) const {
  Eigen::Matrix<double, 3, 6> J;
  Eigen::Map<Eigen::Vector3d>{residuals} =
      planar_residual(sigma_z_m_, sigma_tilt_rad_, from_block(parameters[0]), &J);
  if (jacobians != nullptr && jacobians[0] != nullptr) to_block_jacobian<3>(J, jacobians[0]);
  return true;
}

void GraduatedLoss::Evaluate(double s, double rho[3]) const {
  const double share = m_ / (m_ + s);
  rho[0] = share * s;
  rho[1] = share * share;
  rho[2] = -2.0 * share * share / (m_ + s);
}

Matrix6d sqrt_information(const Matrix6d& covariance) {
  const Matrix6d symmetric = 0.5 * (covariance + covariance.transpose());
  const Eigen::LLT<Matrix6d> cholesky(symmetric);
  if (!symmetric.allFinite() || cholesky.info() != Eigen::Success) return Matrix6d::Identity();
  // covariance = L L^T, so S = L^-1.
  return cholesky.matrixL().solve(Matrix6d::Identity());
}

}  // namespace fusion_slam
