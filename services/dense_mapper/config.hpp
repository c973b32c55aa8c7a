// What the dense mapper can be told. Resolution, height band and camera noise come with ROBOT_MODEL
// and CAMERA_MODEL; these are constants with a reason.
#pragma once

#include <cstdint>

namespace fusion_slam {

struct DenseMapperConfig {
  // --- depth to points
  int stride_px = 2;     // rims and legs are a few pixels wide; 4 points a voxel of 5 cm at 5 m
  int edge_step_px = 1;  // flying pixels lie within about 2 px of an edge
  double edge_sigmas =
      4.0;  // a second difference of inverse depth beyond this many of its own sigmas is an edge
  double grazing_cosine = 0.04;  // 2.3 degrees: a surface seen flatter moves by more than it shows

  // --- occupancy (OctoMap's own sensor model and bounds, Hornung et al. 2013)
  double probability_hit = 0.7;
  double probability_miss = 0.4;
  double log_odds_min = -2.0;
  double log_odds_max = 3.5;
  double free_margin_sigmas = 2.0;  // a ray says "free" only this far in front of its end

  // --- submaps
  std::int64_t keyframes_per_submap =
      5;  // about 1-2 m of path: rigid enough, and few enough anchors
  double slack_voxels =
      0.5;  // a submap is placed anew when the graph moved a point of it by more than this
  std::size_t max_waiting = 512;  // keyframes without a pose in the graph; about 200 KB each

  std::int64_t open_submaps = 4;  // a keyframe missing for longer than these isn't waited for
  // Voxels of a submap that this many newer ones know too are dropped: the clamped sum (3.5, and -2
  // a submap at most) has forgotten them after two.
  int submaps_that_count = 4;
  // While the submaps hold more than so many times what the map composed of them does (which is the
  // area), up to so many more of them are looked at for each that closes. A drive through new rooms
  // holds 2 times as much.
  double submaps_over_map = 3.0;
  int more_superseded = 3;

  // --- publishing
  // Anchors that move are followed this often, in the graph's utime: the map has to follow within a
  // second, and ten moved submaps take half of it.
  std::int64_t moved_period_us = 400'000;
};

}  // namespace fusion_slam
