// What the loop detector may be told. One set for every robot and building.
#pragma once

#include <cstddef>
#include <cstdint>

#include "libs/graph/edge_noise.hpp"
#include "libs/places/config.hpp"

namespace fusion_slam {

struct LidarCheckConfig {
  int coarse_points = 120;
  int fine_points = 300;
  double min_score = 0.6;      // mean match probability of the points in the correlative search
  double min_agreement = 0.7;  // of the points in known space
  double min_coverage = 0.6;   // of all points
  double weak_sigma_m = 0.1;   // worst direction, of the scan alone: beyond, it says too little
  // Somewhere else in the window nearly as good: the scan can't tell the two places apart.
  double rival_score = 0.92;  // of the best one's
  double rival_apart_m = 0.5;
  double rival_apart_rad = 0.35;
  double prior_sigma_m = 0.3;  // of the refinement, about the correlative match
  double prior_sigma_rad = 0.2;
  // Neighbouring beams err together and the submap is made of scans that erred, too.
  double optimism = 4.0;  // on the match's covariance
  double floor_m = 0.01;
  double floor_rad = 0.003;
};

struct LidarSearchConfig {  // closures that the LiDAR finds by itself
  double every_m = 0.5;     // between searches: nodes nearer than this see the same
  double every_rad = 0.5;
  int most_submaps = 2;            // searched at a node, the likeliest first
  std::int64_t min_node_gap = 50;  // nodes since the submap was left: half a submap and more
  double sigmas = 3.0;             // of the graph's uncertainty: the search window
  double min_window_m = 0.25;
  double max_window_m = 8.0;
  double min_window_rad = 0.1;
  double max_window_rad = 1.2;
  // Where no edge leads: any heading, the widest window, and no rival in so many submaps.
  std::size_t most_rival_submaps = 32;
  double near_m = 3.0;        // from a place where the submap was made, beyond the window
  double same_place_m = 1.0;  // window within which one match is enough
  int loops_alike = 3;        // loops that must agree with each other, beyond that
};

struct ConsistencyConfig {
  // Squared distance to what the graph says, in units of both uncertainties: 99.9 %.
  double gate_3d = 16.3;  // x, y, yaw
  double gate_6d = 22.5;
  double pair_3d = 11.3;  // of two loops with each other: 99 %
  double pair_6d = 16.8;
  std::size_t most_waiting = 40;      // candidates that wait for others to agree
  std::int64_t wait_us = 60'000'000;  // and how long
  double apart_m = 0.25;              // between nodes that count as two witnesses
  double apart_rad = 0.2;
  int both_sensors_alike = 1;  // loops that must agree, by who found them
  int vision_alike = 2;
  int vision_sure_inliers = 60;  // a view with so many needs no second one
  double far_sigma_m = 1.5;      // where the graph knows less than this, one more
};

struct KnownPlacesConfig {  // seen many times: see known_places.cpp
  // Views of one place: what is seen from there overlaps by more than half.
  double near_m = 0.5;
  double near_rad = 0.35;
  double most_sigma_m = 0.15;  // and certainly so
  double most_sigma_rad = 0.1;
  std::int64_t visit_gap_us = 20'000'000;  // between views of different visits
  std::size_t fewest_visits = 4;           // before the first of their views goes
  std::size_t oldest = 3;                  // views that stay: they hold the map together
  std::size_t newest = 3;                  // and how it looks now
  // What a scan is tied to a keyframe with: where the graph knows more, one more closure says
  // nothing that any map shows.
  double tells_nothing_m = 0.02;
  double tells_nothing_rad = 0.01;
  std::int64_t latest_links = 400;  // scans, longer than candidates wait
};

struct LoopDetectorConfig {
  AppearanceConfig appearance;
  GeometryConfig geometry;
  LidarCheckConfig lidar;
  LidarSearchConfig search;
  ConsistencyConfig consistency;
  KnownPlacesConfig known;
  EdgeNoiseConfig noise;
  std::int64_t scan_gap_us = 300'000;  // between a keyframe and the scan that stands for it
  std::size_t latest_scans = 200;      // whose points are kept for verification
  double verify_window_m = 0.8;        // about the camera's answer: wider than its error, to tell
  double verify_window_rad = 0.3;      // whether the scan fits elsewhere, too
  double tie_sigma_m = 0.03;           // of a keyframe to the scan that stands for it
  double tie_sigma_rad = 0.01;
};

}  // namespace fusion_slam
