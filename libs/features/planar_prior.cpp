#include "libs/features/planar_prior.hpp"

namespace fusion_slam {

Eigen::Vector3d planar_prior_residual(const PlanarPrior& prior, const SE3& T_reference_camera,
                                      PlanarJacobian* jacobian) {
  const SE3 T_camera_base = prior.T_base_camera.inverse();
  const SE3 T_reference_base = T_reference_camera * T_camera_base;
  const Eigen::Vector3d up = T_reference_base.linear().row(2).transpose();  // in base axes
  const double per_m = 1.0 / prior.sigma_z_m;
  const double per_rad = 1.0 / prior.sigma_tilt_rad;
  if (jacobian != nullptr) {
    // The camera moves by (t, w) in its own axes. The base's origin, c in those, moves by t + w x
    // c; up, v in those, becomes v - w x v.
    const Eigen::Vector3d c = T_camera_base.translation();
    const Eigen::RowVector3d up_camera = T_reference_camera.linear().row(2);
    jacobian->setZero();
    jacobian->block<1, 3>(0, 0) = per_m * up_camera;
    jacobian->block<1, 3>(0, 3) = -per_m * up_camera * skew(c);
    jacobian->block<2, 3>(1, 3) =
        per_rad * (prior.T_base_camera.linear() * skew(up_camera.transpose())).topRows<2>();
  }
  return {per_m * T_reference_base.translation().z(), per_rad * up.x(), per_rad * up.y()};
}

}  // namespace fusion_slam
