// Sub-cell scan matching by non-linear least squares (Hess et al. 2016, section IV.C), with its
// uncertainty.
#pragma once

#include "libs/geometry/pose.hpp"
#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// What is known of the pose without the scan, in the grid's frame.
struct PosePrior {
  SE2 T_grid_base;
  double sigma_linear_m = 0.1;
  double sigma_angular_rad = 0.1;
};

struct RefinerOptions {
  // Of one residual. Neighbouring beams err together (same wall, same cells), so this is larger
  // than their spread: it makes the covariance honest and sets how strongly the prediction counts.
  double residual_sigma = 0.5;
  int max_iterations = 12;
};

struct RefinedMatch {
  SE2 T_grid_base;
  // Of xi in T * Exp(xi), (x, y, yaw) in base axes: inverse of the cost's curvature with the
  // prior's, so along a corridor it is the prior's.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  // Of the worst direction of translation, without the prior: infinite where the scan says nothing.
  double weakest_sigma_m = 0.0;
};

// `start` is where the search begins (the correlative match); the prior keeps directions that the
// scan doesn't see. Pure, safe from any thread, one thread inside: equal input gives equal bits.
RefinedMatch refine_match(const Raster& raster, const Points& points_base, const SE2& start,
                          const PosePrior& prior, const RefinerOptions& options = {});

}  // namespace fusion_slam
