// The residuals of the pose graph, with analytic Jacobians. Poses are blocks of libs/pose_manifold.
#pragma once

#include <ceres/loss_function.h>
#include <ceres/sized_cost_function.h>

#include "libs/geometry/pose.hpp"
#include "libs/pose_manifold/pose_manifold.hpp"

namespace fusion_slam {

// local(T_from_to, T_from^-1 * T_to), and its derivatives by the increments of T_from and T_to
// (both pointers or none).
Vector6d relative_pose_error(const SE3& T_from, const SE3& T_to, const SE3& T_from_to,
                             Matrix6d* J_from, Matrix6d* J_to);

// (z / sigma_z, tilt of the up axis towards map x and y / sigma_tilt) of a pose that should be
// level on the floor, and its derivative by the pose's increment.
Eigen::Vector3d planar_residual(double sigma_z_m, double sigma_tilt_rad, const SE3& T_map_base,
                                Eigen::Matrix<double, 3, 6>* J);

// residual = S * local(T_from_to, T_from^-1 * T_to), S^T S = information.
class RelativePoseCost final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  RelativePoseCost(const SE3& T_from_to, const Matrix6d& sqrt_information)
      : T_from_to_(T_from_to), sqrt_information_(sqrt_information) {}
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  SE3 T_from_to_;
  Matrix6d sqrt_information_;
};

// residual = planar_residual().
class PlanarCost final : public ceres::SizedCostFunction<3, 7> {
 public:
  PlanarCost(double sigma_z_m, double sigma_tilt_rad)
      : sigma_z_m_(sigma_z_m), sigma_tilt_rad_(sigma_tilt_rad) {}
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double sigma_z_m_;
  double sigma_tilt_rad_;
};

// Geman-McClure with graduated non-convexity (Yang et al. 2020): rho(s) = m s / (m + s), m = mu *
// chi2. Large mu: least squares. mu = 1: an error far above chi2 costs no more than chi2.
class GraduatedLoss final : public ceres::LossFunction {
 public:
  GraduatedLoss(double chi2, double mu) : m_(chi2 * mu) {}
  void Evaluate(double s, double rho[3]) const override;

 private:
  double m_;
};

// S with S^T S = covariance^-1. A covariance that is not positive definite counts as a wide one (1
// m, 1 rad).
Matrix6d sqrt_information(const Matrix6d& covariance);

}  // namespace fusion_slam
