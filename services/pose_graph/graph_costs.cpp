#include "services/pose_graph/graph_costs.hpp"

#include <Eigen/Cholesky>

namespace fusion_slam {
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
