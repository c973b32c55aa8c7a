#include "services/lidar_mapper/match_scan.hpp"

#include <algorithm>
#include <cmath>

#include "libs/scan_matching/correlative_matcher.hpp"
#include "libs/scan_matching/surface_refiner.hpp"
#include "services/lidar_mapper/voxel_filter.hpp"

namespace fusion_slam {
namespace {

struct Attempt {
  SurfaceMatch refined;
  Overlap overlap;
};

// What all attempts on one scan share.
struct Task {
  const Submap& submap;
  const SearchPyramid& pyramid;
  Points coarse, fine;  // distortion removed as predicted
  SweepPoints sweep;    // those of `fine`
  MotionPrior prior;
  SurfaceRefinerOptions options;
};

SweepPoints pick_points(const SweepPoints& all, const std::vector<std::size_t>& indices) {
  return {pick(all.points, indices), pick(all.normals, indices),
          all.time_s.empty() ? all.time_s : pick(all.time_s, indices)};
}

Attempt attempt(const Task& task, const SearchWindow& window) {
  const Raster& raster = task.submap.raster();
  const SE2& predicted = task.prior.T_grid_base;
  SE2 start = predicted;
  if (const auto found = match_correlative(task.pyramid, task.coarse, predicted, window, 0.0))
    start = found->T_grid_base;

  // Again with those points only that the map can know, judged at the predicted place with the
  // heading just found.
  const SE2 place{predicted.x, predicted.y, start.yaw};
  const int reach = 1 + static_cast<int>(window.linear_m / 3.0 / raster.resolution_m());
  const Points known = points_in_known_space(raster, task.coarse, place, reach);
  if (known.size() < task.coarse.size() && 2 * known.size() > task.coarse.size())
    if (const auto found = match_correlative(task.pyramid, known, predicted, window, 0.0))
      start = found->T_grid_base;

  const std::vector<std::size_t> inside = indices_in_known_space(raster, task.fine, place, reach);
  const bool enough = 2 * inside.size() > task.fine.size();
  Attempt result;
  result.refined = refine_on_surfaces(task.submap.surfaces(), raster,
                                      enough ? pick_points(task.sweep, inside) : task.sweep, start,
                                      task.prior, task.options);
  result.overlap = measure_overlap(raster, task.fine, result.refined.T_grid_base);
  return result;
}

}  // namespace

ScanMatch match_scan(const Submap& submap, const SearchPyramid& pyramid, const ScanPoints& points,
                     const SE2& T_odom_predicted, const Prediction& prediction,
                     const Eigen::Matrix3d& covariance, const RobotModel& robot,
                     const LidarMapperConfig& config) {
  Task task{submap, pyramid, {}, {}, {}, {}, {}};
  task.coarse =
      pick(points.hits_base,
           adaptive_voxel_indices(points.hits_base, config.coarse_edge_m, config.coarse_points));
  const auto fine =
      adaptive_voxel_indices(points.hits_base, config.coarse_edge_m, config.fine_points);
  task.fine = pick(points.hits_base, fine);
  task.sweep = pick_points(points.sweep, fine);
  task.prior = {submap.T_odom_submap().inverse() * T_odom_predicted, covariance, prediction.twist,
                prediction.twist_sigma};
  task.options.sigma_m = std::max(robot.lidar.sigma_m, 0.2 * robot.map_resolution_m);
  const double cell_m = submap.raster().resolution_m();
  SearchWindow window;
  window.linear_m =
      std::clamp(prediction.window_m, config.least_window_cells * cell_m, config.max_window_m);
  window.angular_rad = std::clamp(prediction.window_rad, config.least_window_rad, M_PI);
  Attempt best = attempt(task, window);
  if (best.overlap.agreement() < config.weak_agreement) {  // it moved in a way nobody foresaw?
    window.linear_m = std::clamp(config.retry_window_factor * window.linear_m,
                                 config.retry_window_m, config.max_window_m);
    window.angular_rad =
        std::clamp(config.retry_window_factor * window.angular_rad, config.retry_window_rad, M_PI);
    task.prior.covariance += Eigen::Vector3d(window.linear_m, window.linear_m, window.angular_rad)
                                 .array()
                                 .square()
                                 .matrix()
                                 .asDiagonal();
    const Attempt wide = attempt(task, window);
    if (wide.overlap.n_matched > best.overlap.n_matched) best = wide;
  }
  if (best.overlap.coverage() < config.lost_coverage ||
      best.overlap.agreement() < config.lost_agreement)
    return dead_reckon(T_odom_predicted, prediction, "the scan fits nowhere near the prediction");

  ScanMatch match;
  match.T_odom_base = submap.T_odom_submap() * best.refined.T_grid_base;
  match.twist = best.refined.twist;
  match.information = best.refined.information;
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
  match.twist = prediction.twist;
  match.reason = reason;
  return match;
}

}  // namespace fusion_slam
