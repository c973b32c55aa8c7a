// The residuals of the pose graph, with analytic Jacobians. Poses are blocks of libs/pose_manifold.
#pragma once

#include <ceres/loss_function.h>
#include <ceres/sized_cost_function.h>

#include "libs/geometry/pose.hpp"
#include "libs/pose_manifold/pose_manifold.hpp"
#include "libs/pose_manifold/relative_pose_cost.hpp"

namespace fusion_slam {

// (z / sigma_z, tilt of the up axis towards map x and y / sigma_tilt) of a pose that should be
// level on the floor, and its derivative by the pose's increment.
Eigen::Vector3d planar_residual(double sigma_z_m, double sigma_tilt_rad, const SE3& T_map_base,
                                Eigen::Matrix<double, 3, 6>* J);

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
