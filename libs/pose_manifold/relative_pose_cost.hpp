// A measured motion between two poses as a residual of least squares, with analytic Jacobians: an
// edge of the pose graph, or what surfaces say between two keyframes.
#pragma once

#include <ceres/sized_cost_function.h>

#include "libs/geometry/pose.hpp"
#include "libs/pose_manifold/pose_manifold.hpp"

namespace fusion_slam {

// local(T_from_to, T_from^-1 * T_to), and its derivatives by the increments of T_from and T_to
// (both pointers or none).
Vector6d relative_pose_error(const SE3& T_from, const SE3& T_to, const SE3& T_from_to,
                             Matrix6d* J_from, Matrix6d* J_to);

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

}  // namespace fusion_slam
