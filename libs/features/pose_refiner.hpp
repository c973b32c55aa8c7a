// The most likely camera pose given matches and a guess: robust least squares over the pose alone.
// Sources: Mur-Artal & Tardos 2017, section III-C (pose-only adjustment with stereo-like
// observations); Huber 1964; Levenberg-Marquardt as in Madsen et al. 2004.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "libs/camera/camera_model.hpp"
#include "libs/features/correspondence.hpp"
#include "libs/features/planar_prior.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// What else is known of the pose: Gaussian around T_reference_camera, not robust.
struct CameraPosePrior {
  SE3 T_reference_camera = SE3::Identity();
  Matrix6d information = Matrix6d::Zero();  // of xi in retract(), camera axes
};

struct RefineConfig {
  int rounds = 3;         // after each, matches beyond the gate are set aside (and may come back)
  int iterations = 8;     // of a round at most
  double gate_2d = 5.99;  // chi square, 95 %, 2 degrees of freedom: matches without depth
  double gate_3d = 7.81;  // 3 degrees of freedom
  std::optional<CameraPosePrior> prior;
  std::optional<PlanarPrior> planar;  // a base that stays on the reference's z = 0
};

struct RefinedPose {
  SE3 T_reference_camera = SE3::Identity();
  Matrix6d covariance =
      Matrix6d::Identity();  // of xi in retract(T_reference_camera, xi): camera axes
  std::vector<bool> inlier;  // one a match
  int n_inliers = 0;
  double mean_chi2 =
      0.0;  // of the inliers, per degree of freedom: about 1 when the noise model is right
};

using ResidualJacobian = Eigen::Matrix<double, 3, 6>;

// Whitened residual (u, v, depth; depth is 0 when there is none) of one match, and its derivative
// by xi in retract(T_reference_camera, xi) when `jacobian` is given and by p_reference when
// `by_point` is. False when the point is behind the camera.
bool pose_residual(const CameraModel& camera, const Correspondence& match,
                   const SE3& T_reference_camera, Eigen::Vector3d* residual,
                   ResidualJacobian* jacobian, Eigen::Matrix3d* by_point = nullptr);

// With fewer than 4 inliers and no prior the covariance is very wide (identity). Never fails: look
// at n_inliers.
RefinedPose refine_pose(const CameraModel& camera, const std::vector<Correspondence>& matches,
                        const SE3& guess_T_reference_camera, const RefineConfig& config = {});

// The covariance of a camera's motion, told in the axes of the robot's base: xi_base =
// Ad(T_base_camera) xi_camera.
Matrix6d in_base_axes(const Matrix6d& covariance_camera, const SE3& T_base_camera);

}  // namespace fusion_slam
