// Constants of the LiDAR mapper. None is meant to be tuned per building: what depends on sensor or
// map comes from RobotModel (resolution, ranges, rate); the rest says here why it is what it is.
#pragma once

namespace fusion_slam {

struct LidarMapperConfig {
  // --- points
  double max_range_cells =
      1000.0;  // beams beyond this many cells (50 m at 5 cm) cost more memory than they tell
  double coarse_edge_m = 0.5;  // the filter's voxel is at most this, smaller where points are few
  int coarse_points = 100;     // correlative search: enough to tell poses apart
  int fine_points = 300;       // refinement: about one sweep of a cheap LiDAR
  int min_points = 20;         // fewer returns than this can't place a robot

  // --- prediction: what a wheeled robot can do
  double max_speed_mps = 2.5;
  double max_turn_radps = 4.0;
  // Sigmas to begin with; how well each source really predicts is learned from the matches.
  double speed_change_mps = 0.33;  // predicted less true speed without odometry
  double turn_change_radps = 0.67;
  double odometry_error = 0.1;      // of the motion it reports: slip
  double odometry_sigma_m = 0.015;  // when it reports no motion
  double odometry_sigma_rad = 0.02;
  double max_extrapolation_s = 0.3;  // odometry older than this says nothing of now

  // --- match
  double least_window_cells = 1.5;  // the grid's own error
  double least_window_rad = 0.03;
  double max_window_m = 2.0;         // after a gap in the scans
  double retry_window_factor = 3.0;  // second search when the first match disagrees with the map
  double retry_window_m = 0.4;       // at least: wheels slip, cameras err
  double retry_window_rad = 0.6;
  double weak_agreement = 0.5;  // of the points in known space
  double lost_agreement = 0.3;
  double lost_coverage = 0.1;      // of all points: so few in known space match anything
  double weak_sigma_m = 0.03;      // worst direction, of the scan alone: a corridor
  int lost_scans_to_restart = 10;  // then a new submap begins: the map goes on, the graph mends it

  // --- nodes and submaps
  double node_distance_m = 0.2;
  double node_angle_rad = 0.06;
  int nodes_per_half_submap = 60;  // a submap holds twice this; at 0.2 m: 24 m of path
  int nodes_per_publication = 10;  // changed tiles of the active submaps go out every so many nodes

  // --- occupancy (paper, equations 3-5 and 7)
  double hit_probability = 0.62;
  double miss_probability = 0.45;
  double min_probability = 0.12;  // clamps: a cell may change its mind after a few scans
  double max_probability = 0.97;
};

}  // namespace fusion_slam
