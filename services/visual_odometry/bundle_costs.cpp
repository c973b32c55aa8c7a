#include "services/visual_odometry/bundle_costs.hpp"

#include "libs/features/pose_refiner.hpp"

namespace fusion_slam {
namespace {

constexpr double kBehind = 30.0;  // whitened residual of a point behind the camera

template <int Rows, int Columns>
using RowMajor = Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>;

}  // namespace

CameraPoseBlock to_camera_block(const SE3& T_odom_camera) {
  const Eigen::Quaterniond q(T_odom_camera.linear());
  const Eigen::Vector3d t = T_odom_camera.translation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

SE3 from_camera_block(const double* block) {
  return make_pose({block[0], block[1], block[2]}, block[6], block[3], block[4], block[5]);
}

bool CameraPoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const CameraPoseBlock moved =
      to_camera_block(retract(from_camera_block(x), Eigen::Map<const Vector6d>(delta)));
  std::copy(moved.begin(), moved.end(), x_plus_delta);
  return true;
}

bool CameraPoseManifold::PlusJacobian(const double* /*x*/, double* jacobian) const {
  Eigen::Map<RowMajor<7, 6>>(jacobian).setIdentity();
  return true;
}

bool CameraPoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Vector6d> difference(y_minus_x);
  difference = local(from_camera_block(x), from_camera_block(y));
  return true;
}

bool CameraPoseManifold::MinusJacobian(const double* /*x*/, double* jacobian) const {
  Eigen::Map<RowMajor<6, 7>>(jacobian).setIdentity();
  return true;
}

bool ObservationCost::Evaluate(const double* const* parameters, double* residuals,
                               double** jacobians) const {
  Correspondence seen = seen_;
  seen.p_reference = Eigen::Map<const Eigen::Vector3d>(parameters[1]);
  Eigen::Vector3d residual;
  ResidualJacobian by_pose = ResidualJacobian::Zero();
  Eigen::Matrix3d by_point = Eigen::Matrix3d::Zero();
  const bool wanted = jacobians != nullptr;
  if (!pose_residual(camera_, seen, from_camera_block(parameters[0]), &residual,
                     wanted ? &by_pose : nullptr, wanted ? &by_point : nullptr))
    residual.setConstant(kBehind);
  Eigen::Map<Eigen::Vector3d> out(residuals);
  out = residual;
  if (!wanted) return true;
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor<3, 7>> J(jacobians[0]);
    J.leftCols<6>() = by_pose;
    J.col(6).setZero();
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<RowMajor<3, 3>> J(jacobians[1]);
    J = by_point;
  }
  return true;
}

bool PlanarPriorCost::Evaluate(const double* const* parameters, double* residuals,
                               double** jacobians) const {
  const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
  PlanarJacobian by_pose;
  Eigen::Map<Eigen::Vector3d> out(residuals);
  out =
      planar_prior_residual(prior_, from_camera_block(parameters[0]), wanted ? &by_pose : nullptr);
  if (!wanted) return true;
  Eigen::Map<RowMajor<3, 7>> J(jacobians[0]);
  J.leftCols<6>() = by_pose;
  J.col(6).setZero();
  return true;
}

}  // namespace fusion_slam
