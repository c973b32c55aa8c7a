// Finds where in a window around a prediction a scan fits a grid best: exhaustive in effect,
// branch-and-bound in cost (Olson 2009; Hess et al. 2016, section V.B). Exact to one cell and one
// angular step; scan_refiner does the rest. Pure functions, safe from any thread.
#pragma once

#include <optional>

#include "libs/geometry/pose.hpp"
#include "libs/scan_matching/raster.hpp"
#include "libs/scan_matching/search_pyramid.hpp"

namespace fusion_slam {

struct SearchWindow {
  double linear_m = 0.2;     // +- in x and in y of the grid's frame
  double angular_rad = 0.3;  // +-; pi and above: every heading
  // Taken from the score at the window's edge (1 linear + 1 angular there: twice this), growing
  // with the square of the distance: among equals the one near the prediction wins. 0 where the
  // prediction is worth nothing.
  double edge_penalty = 0.05;
};

// The window that holds the truth when the prediction's error has this covariance: of (x, y, yaw),
// the translation along the grid's axes, metres and radians. `sigmas` to each side, at least
// `least`, at most `most` (their edge_penalty is not looked at). The penalty at the edge stays the
// default. To turn a covariance of base axes: grid_axes().
SearchWindow window_from_covariance(const Eigen::Matrix3d& covariance_grid, double sigmas,
                                    const SearchWindow& least, const SearchWindow& most);

// Covariance of xi in T_grid_base * xi (base axes) as one of the pose's x, y, yaw in the grid.
Eigen::Matrix3d grid_axes(const Eigen::Matrix3d& covariance_base, double yaw_rad);

struct CorrelativeMatch {
  SE2 T_grid_base;
  double score = 0.0;  // mean match probability of the points, less the penalty
};

// The best pose of the window with a score above min_score; nothing when there is none (or no
// points). Equal scores: the first in the order of angle, then translation; so the result depends
// on the input only.
std::optional<CorrelativeMatch> match_correlative(const SearchPyramid& pyramid,
                                                  const Points& points_base,
                                                  const SE2& T_grid_base_predicted,
                                                  const SearchWindow& window, double min_score);

// Angle by which most points move less than one cell.
double angular_step(const Points& points_base, double resolution_m);

}  // namespace fusion_slam
