// When a place in a saved map is believed. One set for every robot and building.
#pragma once

#include <cstdint>

#include "libs/places/config.hpp"

namespace fusion_slam {

struct MapSearchConfig {
  double cell_m = 0.1;      // of the full-map search; the answer is then refined on the map's cells
  int search_points = 160;  // of all that was seen lately
  int fine_points = 400;
  double min_score = 0.45;     // mean match probability in the full-map search
  double min_agreement = 0.7;  // of the points in known space
  double min_coverage = 0.6;   // of all points
  double apart_m = 0.6;        // another place, not the same one again
  double apart_rad = 0.35;
  double prior_sigma_m = 0.3;  // of the refinement, about where the search ended
  double prior_sigma_rad = 0.1;
};

struct LocalizerConfig {
  AppearanceConfig appearance;
  GeometryConfig geometry;
  MapSearchConfig lidar;

  // What is looked for in the map: all scans of the latest way, so that two alike corners differ.
  double memory_m = 4.0;
  std::int64_t memory_us = 20'000'000;
  // Between full-map searches.
  double search_every_m = 0.15;
  double search_every_rad = 0.2;
  // The longer nothing is found, the rarer the search: after so many, twice the way in between,
  // after twice as many three times, at most ten times. Large maps cost most where they don't
  // match.
  int patient_searches = 12;

  // Two answers are one place (odometry drifts little in between).
  double same_m = 0.35;
  double same_rad = 0.12;
  std::int64_t answer_memory_us = 12'000'000;

  // Camera and LiDAR: the place that the camera knows must be among the LiDAR's best, to this share
  // of the best score of the whole map.
  double among_best = 0.95;
  int views_weighed = 3;  // the latest answers of the camera, against each of the LiDAR's
  // LiDAR alone: no other place of the map may score as much as this share, more of the points must
  // agree, and searches from several places on the way must give the same answer.
  double rival_score = 0.9;
  double alone_agreement = 0.8;
  int alone_answers = 3;
  double alone_way_m = 0.4;    // between the first and the last of them, or
  double alone_way_rad = 0.5;  // turned
  // Camera alone (maps and robots without LiDAR): views from different places that agree.
  int camera_answers = 2;
  double camera_apart_m = 0.1;
  double camera_apart_rad = 0.1;
  int camera_sure_inliers = 60;  // a view with so many needs no second one

  // Once localised: about the prediction.
  double track_window_m = 0.3;
  double track_window_rad = 0.1;
  double track_agreement = 0.55;
  double lost_agreement = 0.4;  // of points in known space: below, a scan contradicts the map
  int lost_after = 8;           // scans in a row
};

}  // namespace fusion_slam
