#include "services/visual_odometry/bundle_costs.hpp"

#include "libs/features/pose_refiner.hpp"
#include "libs/pose_manifold/pose_manifold.hpp"

namespace fusion_slam {
namespace {

constexpr double kBehind = 30.0;  // whitened residual of a point behind the camera

}  // namespace

bool ObservationCost::Evaluate(const double* const* parameters, double* residuals,
                               double** jacobians) const {
  Correspondence seen = seen_;
  seen.p_reference = Eigen::Map<const Eigen::Vector3d>(parameters[1]);
  Eigen::Vector3d residual;
  ResidualJacobian by_pose = ResidualJacobian::Zero();
  Eigen::Matrix3d by_point = Eigen::Matrix3d::Zero();
  const bool wanted = jacobians != nullptr;
  if (!pose_residual(camera_, seen, from_block(parameters[0]), &residual,
                     wanted ? &by_pose : nullptr, wanted ? &by_point : nullptr))
    residual.setConstant(kBehind);
  Eigen::Map<Eigen::Vector3d> out(residuals);
  out = residual;
  if (!wanted) return true;
  if (jacobians[0] != nullptr) to_block_jacobian<3>(by_pose, jacobians[0]);
  if (jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> J(jacobians[1]);
    J = by_point;
  }
  return true;
}

bool PlanarPriorCost::Evaluate(const double* const* parameters, double* residuals,
                               double** jacobians) const {
  const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
  PlanarJacobian by_pose;
  Eigen::Map<Eigen::Vector3d> out(residuals);
  out = planar_prior_residual(prior_, from_block(parameters[0]), wanted ? &by_pose : nullptr);
  if (wanted) to_block_jacobian<3>(by_pose, jacobians[0]);
  return true;
}

}  // namespace fusion_slam
