// The least-squares terms of scan matching (Hess et al. 2016, equation CS): how far from 1 the
// smoothed match probability is at each transformed point, and how far the pose is from its
// prediction.
#pragma once

#include <ceres/ceres.h>

#include "libs/geometry/pose.hpp"
#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// Match probability between cell centres: bicubic (Catmull-Rom), so value and gradient are
// continuous.
struct Interpolated {
  double value = 0.0;
  double d_dx = 0.0;  // per metre
  double d_dy = 0.0;
};
Interpolated interpolate_probability(const Raster& raster, double x_m, double y_m);

// One residual a point, (1 - M(T_grid_base p)) / sigma; parameters x, y, yaw of T_grid_base. Keeps
// references: raster and points must outlive it.
class OccupancyCost : public ceres::CostFunction {
 public:
  OccupancyCost(const Raster& raster, const Points& points_base, double sigma);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Raster& raster_;
  const Points& points_;
  double sigma_;
};

// Three residuals: (pose - prediction) / sigma, in the grid's frame.
class PriorCost : public ceres::SizedCostFunction<3, 3> {
 public:
  PriorCost(const SE2& predicted, double sigma_linear_m, double sigma_angular_rad);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  SE2 predicted_;
  double sigma_linear_m_;
  double sigma_angular_rad_;
};

}  // namespace fusion_slam
