// How far edges are believed. One place for it: the pose graph weighs edges by it, and the loop
// detector asks by it where a robot may be that has driven so far.
#pragma once

#include "libs/graph/edge.hpp"

namespace fusion_slam {

struct EdgeNoiseConfig {
  // Trackers report the noise of their matches. Their errors are biased, too (calibration, time
  // stamps), and add up along the way instead of averaging out; without these factors a true loop
  // after a long way would look impossible. On the covariance. Measured against true poses in three
  // simulated buildings (docs/benchmarks.md): chains of 5 to 50 edges err 1.8 to 3.5 times
  // (squared) what the tracker says; a real camera is calibrated worse.
  double visual_optimism = 4.0;
  // Neighbouring scans are matched with the same submap: most of what both matches err in common
  // is not in their difference, so the two covariances' sum is nearly enough.
  double lidar_optimism = 2.0;
  // A submap is bent by what its own scans erred, and a scan fits all of it alike: measured squared
  // errors are 1.5 to 5 times what the matches say.
  double lidar_loop_optimism = 4.0;
  // And this is added, so that no edge is perfect.
  double floor_translation_m = 0.003;
  double floor_rotation_rad = 0.001;

  // What a 2D scan says of z, roll and pitch from node to node: on a floor that they stay,
  // otherwise nearly nothing (only enough to keep the equations regular).
  double lidar_planar_z_m = 0.001;
  double lidar_planar_tilt_rad = 0.001;
  double lidar_free_z_m = 1.0;
  double lidar_free_tilt_rad = 0.5;
};

// The covariance an edge is solved with: its own, a tracker's bias allowed for, what its sensor
// can't see widened or pinned, and the floor added.
Matrix6d effective_covariance(const EdgeNoiseConfig& config, const GraphEdge& edge, bool planar);

// Of a chain a -> b -> c: the covariance of T_a_c, in c's axes, of those of T_a_b and T_b_c.
Matrix6d chained_covariance(const Matrix6d& of_a_b, const SE3& T_b_c, const Matrix6d& of_b_c);

// The covariance of T_b_a, in a's axes, of that of T_a_b.
Matrix6d inverse_covariance(const Matrix6d& of_a_b, const SE3& T_a_b);

// How a small motion in b's axes shows in a's: xi_a = adjoint(T_a_b) * xi_b.
Matrix6d adjoint(const SE3& T_a_b);

}  // namespace fusion_slam
