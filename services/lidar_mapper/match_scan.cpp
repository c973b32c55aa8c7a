#include "services/lidar_mapper/match_scan.hpp"

#include <algorithm>
#include <cmath>

#include "libs/scan_matching/correlative_matcher.hpp"
#include "libs/scan_matching/scan_refiner.hpp"
#include "services/lidar_mapper/voxel_filter.hpp"

namespace fusion_slam {
namespace {

struct Attempt {
  RefinedMatch refined;
  Overlap overlap;
};

Attempt attempt(const Raster& raster, const SearchPyramid& pyramid, const Points& coarse,
                const Points& fine, const SE2& predicted, const SearchWindow& window) {
  SE2 start = predicted;
  if (const auto found = match_correlative(pyramid, coarse, predicted, window, 0.0))
    start = found->T_grid_base;

  // Again with those points only that the map can know, judged at the predicted place with the
  // heading just found.
  const SE2 place{predicted.x, predicted.y, start.yaw};
  const double sigma_m = window.linear_m / 3.0;
  const int reach = 1 + static_cast<int>(sigma_m / raster.resolution_m());
  const Points known = points_in_known_space(raster, coarse, place, reach);
  const Points known_fine = points_in_known_space(raster, fine, place, reach);
  if (known.size() < coarse.size() && 2 * known.size() > coarse.size())
    if (const auto found = match_correlative(pyramid, known, predicted, window, 0.0))
      start = found->T_grid_base;

  const PosePrior prior{predicted, sigma_m, window.angular_rad / 3.0};
  Attempt result;
  const bool enough = 2 * known_fine.size() > fine.size();
  result.refined = refine_match(raster, enough ? known_fine : fine, start, prior);
  result.overlap = measure_overlap(raster, fine, result.refined.T_grid_base);
  return result;
}

}  // namespace

ScanMatch match_scan(const Submap& submap, const SearchPyramid& pyramid, const Points& points_base,
                     const SE2& T_odom_predicted, const Prediction& prediction,
                     const LidarMapperConfig& config) {
  const Points coarse =
      adaptive_voxel_filter(points_base, config.coarse_edge_m, config.coarse_points);
  const Points fine = adaptive_voxel_filter(points_base, config.coarse_edge_m, config.fine_points);
  const SE2 predicted = submap.T_odom_submap().inverse() * T_odom_predicted;
  SearchWindow window;
  window.linear_m = prediction.window_m;
  window.angular_rad = prediction.window_rad;
  Attempt best = attempt(submap.raster(), pyramid, coarse, fine, predicted, window);
  if (best.overlap.agreement() < config.weak_agreement) {  // it moved in a way nobody foresaw?
    window.linear_m = std::clamp(config.retry_window_factor * window.linear_m,
                                 config.retry_window_m, config.max_window_m);
    window.angular_rad =
        std::clamp(config.retry_window_factor * window.angular_rad, config.retry_window_rad, M_PI);
    const Attempt wide = attempt(submap.raster(), pyramid, coarse, fine, predicted, window);
    if (wide.overlap.n_matched > best.overlap.n_matched) best = wide;
  }
  if (best.overlap.coverage() < config.lost_coverage ||
      best.overlap.agreement() < config.lost_agreement)
    return dead_reckon(T_odom_predicted, prediction, "the scan fits nowhere near the prediction");

  ScanMatch match;
  match.T_odom_base = submap.T_odom_submap() * best.refined.T_grid_base;
  match.covariance = best.refined.covariance;
  match.state = MatchState::kOk;
  match.overlap = best.overlap;
  if (best.overlap.agreement() < config.weak_agreement) {
    match.state = MatchState::kWeak;
    match.reason = "half of the scan disagrees with the map";
  } else if (best.refined.weakest_sigma_m > config.weak_sigma_m) {
    match.state = MatchState::kWeak;
    match.reason = "the scan does not fix the position in one direction";
  }
  return match;
}

ScanMatch dead_reckon(const SE2& T_odom_predicted, const Prediction& prediction,
                      const char* reason) {
  ScanMatch match;
  match.T_odom_base = T_odom_predicted;
  match.covariance =
      Eigen::Vector3d(prediction.window_m, prediction.window_m, prediction.window_rad)
          .array()
          .square()
          .matrix()
          .asDiagonal();
  match.reason = reason;
  return match;
}

}  // namespace fusion_slam
