// What a robot that drives on a flat floor knows about its pose before it looks: its base's height,
// roll and pitch stay what they were when odom began. Weak next to hundreds of features in one
// frame; what it ends is the slow drift of height and tilt, and it holds what few features leave
// open. Source: the soft planar constraint of Zheng, Tang & Liu 2018 (SE(2)-XYZ).
#pragma once

#include <Eigen/Core>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

struct PlanarPrior {
  SE3 T_base_camera = SE3::Identity();
  double sigma_z_m = 0.005;  // a floor's unevenness below the wheels
  double sigma_tilt_rad =
      0.003;  // rocking; less than a careless mounting, which Huber's loss bears
};

using PlanarJacobian = Eigen::Matrix<double, 3, 6>;

// Whitened height of the base above z = 0 of the reference and the reference's up along the base's
// x and y axes (pitch and roll, for small angles); derivative by xi in
// retract(T_reference_camera, xi) when `jacobian` is given. Pure.
Eigen::Vector3d planar_prior_residual(const PlanarPrior& prior, const SE3& T_reference_camera,
                                      PlanarJacobian* jacobian);

}  // namespace fusion_slam
