// What the pose graph believes about its inputs beyond their own covariances. One set for every
// robot and building.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "libs/graph/edge_noise.hpp"
#include "services/pose_graph/landmark_store.hpp"

namespace fusion_slam {

// Global bundle adjustment: keyframes, LiDAR nodes and landmarks at once.
struct BundleConfig {
  double pixel_sigma = 0.6;   // a corner is found to about half a pixel of its octave's
  double octave_scale = 1.2;  // as the feature extractor's
  TrackLimits limits;
  int least_points = 50;  // fewer say nothing about a graph
  // Two keyframes that share so many points need no edge of their own: theirs is believed this much
  // less (on the covariance), for it was made of the same features.
  int covered_points = 30;
  double covered_factor = 100.0;
  int iterations = 12;
  // Few edges that agreed before may be contradicted afterwards (99.9 % of a chi-square with 6
  // degrees of freedom): one in a hundred of each kind is a blunder of its sensor; and none by far.
  double gate_chi2 = 22.5;
  double gate_share = 0.01;
  double gate_hard_chi2 = 500.0;
  double growth = 1.25;  // of the keyframes since the last time, before it is worth while again
  std::int64_t meet_after_us = 5'000'000;  // as PoseGraphConfig::meet_after_us; it takes longer
};

// Nodes in places that older ones have seen leave the graph (thinning.hpp), so that it grows with
// the area and not with time.
struct ThinningConfig {
  double within_m = 0.5;     // half a room's width further other things are seen
  double within_rad = 0.35;  // 20 degrees: of the camera's 58 most is the same; LiDAR: any
  int enough = 2;            // older ones of the same sensor: one may be a bad one
  // What came later than this is not judged: loops to it are still being found and doubted.
  std::int64_t after_us = 120'000'000;
  int every = 32;                 // nodes; each look costs as much as a window's solve
  double carrier_sigma_m = 0.05;  // a node that no neighbour knows so well stays
};

struct PoseGraphConfig {
  BundleConfig bundle;
  ThinningConfig thinning;
  EdgeNoiseConfig noise;  // how far edges are believed

  // A planar robot's base stays on the floor. Wider for single nodes than one frame's noise, so
  // that a camera mounted a degree off bends nothing.
  double planar_z_m = 0.02;
  double planar_tilt_rad = 0.01;

  // Between two scans the robot may have accelerated this much: sets how far an interpolated pose
  // is trusted.
  double max_acceleration_mps2 = 1.0;
  double max_angular_acceleration_radps2 = 2.0;
  std::int64_t max_interpolation_gap_us =
      500'000;  // a longer gap isn't a trajectory, it is a guess
  std::int64_t max_wait_us =
      2'000'000;  // for a node that others refer to; after that it counts as lost
  std::int64_t track_memory_us = 60'000'000;  // poses older than this are never asked for again

  // Wheel odometry (differential drive, indoor floors): standard deviation as a share of the
  // motion.
  double odometry_slip = 0.05;
  double odometry_turn_slip = 0.05;

  // A visual edge is doubted when the LiDAR saw the same motion and contradicts it by so much
  // (sensor_agreement.hpp). Over a longer time than this the camera has found itself again: then
  // all that the graph knows stands against it (found_again.cpp).
  double agreement_chi2 = 30.0;
  std::int64_t agreement_us = 5'000'000;

  // A track that broke and starts anew without odometry or the other sensor: it can be this far
  // off, plus this speed times the time it was blind.
  double restart_translation_m = 0.2;
  double restart_rotation_rad = 0.2;
  double restart_speed_mps = 0.5;
  double restart_turn_radps = 0.5;

  // Geman-McClure scale of a loop: squared error, in units of its covariance, where doubt begins;
  // 99 % of a chi-square with 6 degrees of freedom.
  double loop_chi2 = 16.8;

  // A loop nearer than this to the graph can wait for company: 95 % of a chi-square with 3 degrees
  // of freedom, so a right loop in a graph that is right waits.
  double quiet_chi2 = 7.8;
  int most_unsolved_loops = 20;  // but not for more than this
  int quick_iterations = 5;      // of the solve between two messages
  double quick_enough = 1e-4;    // it ends when a step lowers the cost by less than this share
  // The whole graph is solved anew in a thread of its own; its answer is taken over when the
  // measurements are this much later, not before: the same place in every replay.
  std::int64_t meet_after_us = 1'000'000;
  // true: and waited for then, replays give the same bytes. false, on a robot: it is taken over
  // when it is there; no pose ever waits for it.
  bool wait_for_solver = true;
  // Then: of a core, over time. With thousands of loops there is always one that doesn't fit.
  double solver_share = 0.25;
  // And of the thread that says the poses, for solves between two messages: loops that pull wait
  // for one another.
  double quick_share = 0.25;
  std::int64_t longest_quick_us = 50'000;  // one that takes longer is made in a thread of its own
  std::function<void()> solver_begins;     // called in the solver's thread
  int switch_off_after = 2;                // whole solves in a row that a loop did not fit

  std::size_t window_nodes = 20;   // newest nodes refined when the second sensor ties in
  std::size_t max_waiting = 4096;  // poses, nodes and loops that wait for a node that hasn't come
};

}  // namespace fusion_slam
