#include "services/loop_detector/lidar_check.hpp"

#include <cmath>
#include <cstdio>

#include "libs/places/rival_match.hpp"
#include "libs/scan_matching/scan_refiner.hpp"
#include "libs/scan_matching/thinning.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kFewestPoints = 30;

template <class... Values>
std::string say(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

LidarCheck check_scan(const UnpackedSubmap& submap, const Points& points_base,
                      const SE2& T_submap_base_predicted, const SearchWindow& window,
                      const LidarCheckConfig& config) {
  LidarCheck check;
  if (points_base.size() < kFewestPoints) {
    check.reason = "the scan has too few points";
    return check;
  }
  const Points coarse = thinned(points_base, config.coarse_points);
  const Points fine = thinned(points_base, config.fine_points);
  const auto best =
      match_correlative(submap.pyramid, coarse, T_submap_base_predicted, window, config.min_score);
  if (!best) {
    const Overlap there = measure_overlap(submap.raster, fine, T_submap_base_predicted);
    const bool in_known_space = there.coverage() >= config.min_coverage;
    check.opinion = in_known_space ? LidarOpinion::kNowhere : LidarOpinion::kNothing;
    check.score = there.agreement();
    check.reason = say("the scan fits nowhere within %.2f m and %.0f degrees%s", window.linear_m,
                       window.angular_rad * 180.0 / M_PI,
                       in_known_space ? "" : ", most of it outside the submap");
    return check;
  }
  const PosePrior prior{best->T_grid_base, config.prior_sigma_m, config.prior_sigma_rad};
  const RefinedMatch refined = refine_match(submap.raster, fine, best->T_grid_base, prior);
  const Overlap overlap = measure_overlap(submap.raster, fine, refined.T_grid_base);
  check.score = overlap.agreement() * std::min(1.0, overlap.coverage() / config.min_coverage);
  check.T_submap_base = refined.T_grid_base;
  check.covariance = config.optimism * refined.covariance;
  check.covariance.diagonal() +=
      Eigen::Vector3d(config.floor_m * config.floor_m, config.floor_m * config.floor_m,
                      config.floor_rad * config.floor_rad);
  if (overlap.coverage() < config.min_coverage) {
    check.reason = say("%.0f %% of the scan lies in known space", 100.0 * overlap.coverage());
    return check;
  }
  if (overlap.agreement() < config.min_agreement) {
    check.opinion = LidarOpinion::kNowhere;
    check.reason =
        say("%.0f %% of the scan disagrees at the best place", 100.0 * (1.0 - overlap.agreement()));
    return check;
  }
  if (refined.weakest_sigma_m > config.weak_sigma_m) {
    check.reason = "the scan does not fix the position in one direction";
    return check;
  }
  SearchWindow no_penalty = window;
  no_penalty.edge_penalty = 0.0;
  const double score = match_score(submap.pyramid, coarse, best->T_grid_base);
  if (const auto rival =
          find_rival(submap.pyramid, coarse, T_submap_base_predicted, no_penalty, best->T_grid_base,
                     {config.rival_apart_m, config.rival_apart_rad}, config.rival_score * score)) {
    check.reason =
        say("fits as well %.2f m and %.0f degrees away",
            std::hypot(rival->T_grid_base.x - best->T_grid_base.x,
                       rival->T_grid_base.y - best->T_grid_base.y),
            180.0 / M_PI * std::abs(wrap_angle(rival->T_grid_base.yaw - best->T_grid_base.yaw)));
    return check;
  }
  check.opinion = LidarOpinion::kFits;
  check.reason = say("%.0f %% agree, known to %.3f m", 100.0 * overlap.agreement(),
                     std::sqrt(check.covariance.diagonal().head<2>().maxCoeff()));
  return check;
}

}  // namespace fusion_slam
