// The residuals of local bundle adjustment, with analytic derivatives. Poses (T_odom_camera) are
// blocks of libs/pose_manifold.
#pragma once

#include <ceres/sized_cost_function.h>

#include "libs/camera/camera_model.hpp"
#include "libs/features/correspondence.hpp"
#include "libs/features/planar_prior.hpp"
#include "libs/geometry/pose.hpp"

namespace fusion_slam {

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
