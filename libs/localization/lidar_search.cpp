#include "libs/localization/lidar_search.hpp"

#include <algorithm>
#include <cmath>

#include "libs/places/rival_match.hpp"
#include "libs/scan_matching/correlative_matcher.hpp"
#include "libs/scan_matching/overlap.hpp"
#include "libs/scan_matching/scan_refiner.hpp"
#include "libs/scan_matching/thinning.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kFewestPoints = 40;
constexpr double kErrTogether = 4.0;  // on the covariance: neighbouring beams err together
constexpr double kFloor_m = 0.01;
constexpr double kFloor_rad = 0.003;

// From one cell of the search to the map's own: another small search, then least squares.
void refine(const MapGrid& map, const Points& points, const SE2& start, double window_m,
            double window_rad, const MapSearchConfig& config, LidarFix* fix) {
  const Points fine = thinned(points, config.fine_points);
  SearchWindow window;
  window.linear_m = window_m;
  window.angular_rad = window_rad;
  window.edge_penalty = 0.0;
  const auto best =
      match_correlative(map.pyramid, thinned(points, config.search_points), start, window, 0.1);
  const SE2 from = best ? best->T_grid_base : start;
  const RefinedMatch refined =
      refine_match(map.raster, fine, from, {from, config.prior_sigma_m, config.prior_sigma_rad});
  const Overlap overlap = measure_overlap(map.raster, fine, refined.T_grid_base);
  fix->T_map_base = refined.T_grid_base;
  fix->covariance = kErrTogether * refined.covariance;
  fix->covariance.diagonal() +=
      Eigen::Vector3d(kFloor_m * kFloor_m, kFloor_m * kFloor_m, kFloor_rad * kFloor_rad);
  fix->agreement = overlap.agreement();
  fix->coverage = overlap.coverage();
  fix->score = match_score(map.coarse, thinned(points, config.search_points), fix->T_map_base);
}

void judge(const MapSearchConfig& config, LidarFix* fix) {
  if (fix->coverage < config.min_coverage)
    fix->reason = "most of what the LiDAR sees lies outside the map";
  else if (fix->agreement < config.min_agreement)
    fix->reason = "what the LiDAR sees fits nowhere in the map";
  else
    fix->found = true;
}

}  // namespace

LidarFix find_in_map(const MapGrid& map, const Points& points_base, double rival_share,
                     const MapSearchConfig& config) {
  LidarFix fix;
  if (points_base.size() < kFewestPoints) {
    fix.reason = "the LiDAR has seen too little yet";
    return fix;
  }
  const Points coarse = thinned(points_base, config.search_points);
  const SE2 centre{0.5 * (map.min_x + map.max_x), 0.5 * (map.min_y + map.max_y), 0.0};
  SearchWindow window;
  window.linear_m = 0.5 * std::max(map.max_x - map.min_x, map.max_y - map.min_y);
  window.angular_rad = M_PI;
  window.edge_penalty = 0.0;  // every place is as likely as any other
  const auto best = match_correlative(map.coarse, coarse, centre, window, config.min_score);
  if (!best) {
    fix.reason = "what the LiDAR sees fits nowhere in the map";
    return fix;
  }
  refine(map, points_base, best->T_grid_base, 2.0 * map.coarse.resolution_m(),
         2.0 * angular_step(coarse, map.coarse.resolution_m()), config, &fix);
  fix.score = std::max(fix.score, best->score);
  judge(config, &fix);
  if (!fix.found || rival_share >= 1.0) return fix;
  if (const auto rival = find_rival(map.coarse, coarse, centre, window, best->T_grid_base,
                                    {config.apart_m, config.apart_rad}, rival_share * best->score))
    fix.rival_score = rival->score;
  return fix;
}

LidarFix find_near(const MapGrid& map, const Points& points_base, const SE2& T_map_base_predicted,
                   const SearchWindow& window, const MapSearchConfig& config) {
  LidarFix fix;
  if (points_base.size() < kFewestPoints) {
    fix.reason = "the scan has too few points";
    return fix;
  }
  refine(map, points_base, T_map_base_predicted, window.linear_m, window.angular_rad, config, &fix);
  judge(config, &fix);
  return fix;
}

}  // namespace fusion_slam
