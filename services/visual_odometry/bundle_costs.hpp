// The residual of local bundle adjustment, with analytic derivatives, and the manifold of its
// poses.
#pragma once

#include <array>

#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include "libs/camera/camera_model.hpp"
#include "libs/features/correspondence.hpp"
#include "libs/features/planar_prior.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// T_odom_camera as a parameter block: position, then quaternion x, y, z, w.
using CameraPoseBlock = std::array<double, 7>;
CameraPoseBlock to_camera_block(const SE3& T_odom_camera);
SE3 from_camera_block(const double* block);

// Plus is retract(): T * (t, Exp(r)). Derivatives by the increment stand in the first six columns
// of a cost's Jacobian, so this one's is [I6; 0] (as in OKVIS, Leutenegger et al. 2015).
class CameraPoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

// (u, v) / pixel sigma and z / sigma(z) of one observation; the third is 0 when the feature is
// bearing-only. Parameters: pose, point (m, odom). A point behind the camera has a large constant
// residual.
class ObservationCost final : public ceres::SizedCostFunction<3, 7, 3> {
 public:
  // `camera` must outlive this. `seen.p_reference` is not used.
  ObservationCost(const CameraModel& camera, const Correspondence& seen)
      : camera_(camera), seen_(seen) {}
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const CameraModel& camera_;
  Correspondence seen_;
};

// planar_prior_residual() of a moving keyframe's pose.
class PlanarPriorCost final : public ceres::SizedCostFunction<3, 7> {
 public:
  explicit PlanarPriorCost(const PlanarPrior& prior) : prior_(prior) {}
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  PlanarPrior prior_;
};

}  // namespace fusion_slam
