// Places a sweep in a submap as well as the ranges allow: points on walls by their distance to the
// wall (Censi 2008), all others by the bicubic occupancy (Hess et al. 2016, IV.C), the prediction
// as a Gaussian prior; pose and velocity during the sweep together (the distortion is estimated,
// not assumed: Dellenbach et al. 2022, CT-ICP, with constant velocity). Gauss-Newton, 3 or 6
// unknowns.
#pragma once

#include <vector>

#include "libs/scan_matching/surface_map.hpp"
#include "libs/scan_matching/twist.hpp"

namespace fusion_slam {

// Points of a sweep, in base as it stood when their beam was measured.
struct SweepPoints {
  Points points;
  Points normals;              // as many: surface_normals; zero where there is none
  std::vector<double> time_s;  // as many: since the first beam; empty: all at once
};

// What is known without the sweep: the pose at its first beam, with the covariance of xi in
// T * xi, (x, y, yaw) in base axes; and the velocity during it, its axes independent.
struct MotionPrior {
  SE2 T_grid_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity() * 0.01;
  Twist twist;
  Eigen::Vector3d twist_sigma = Eigen::Vector3d::Ones();  // m/s, m/s, rad/s
};

struct SurfaceRefinerOptions {
  double sigma_m = 0.02;         // of a point's distance to its wall: the scanner's noise
  double occupancy_sigma = 0.5;  // of one (1 - occupancy)
  // Errors of neighbouring points are not independent (one wall, one incidence, one cell): so many
  // count as one. Measured where the truth is known: tests/bench/lidar_mapper, NEES near 3.
  double redundancy = 1.0;
  int max_iterations = 10;
};

struct SurfaceMatch {
  SE2 T_grid_base;  // at the first beam
  Twist twist;      // during the sweep: the prior's where the points have no times
  // Of xi in T * xi, (x, y, yaw) in base axes: prior and points together.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  // J^T J / sigma^2 of the points alone, same axes: 0 in directions the sweep says nothing about.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  // Of the worst direction of translation, points alone: infinite where they say nothing.
  double weakest_sigma_m = 0.0;
  int n_on_surfaces = 0;
};

// `start`: where to begin (a correlative match). Surfaces in cells that the raster holds for free
// are not used: what stood there has gone. Pure, deterministic, safe from any thread.
SurfaceMatch refine_on_surfaces(const SurfaceMap& surfaces, const Raster& raster,
                                const SweepPoints& sweep, const SE2& start,
                                const MotionPrior& prior,
                                const SurfaceRefinerOptions& options = {});

// Half the robust sum of squares of the points (without the prior) and its gradient in (x, y, yaw
// of T * xi, vx, vy, turn): for tests, and for whoever compares places.
struct SurfaceCost {
  double value = 0.0;
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
};
SurfaceCost surface_cost(const SurfaceMap& surfaces, const Raster& raster, const SweepPoints& sweep,
                         const SE2& T_grid_base, const Twist& twist,
                         const SurfaceRefinerOptions& options = {});

// 1 sigma of the least known direction of translation when the heading is free to follow.
double weakest_sigma_m(const Eigen::Matrix3d& information);

}  // namespace fusion_slam
