// Where no edge leads from a scan to a submap, the scan may be of anywhere. A match is then worth
// something only when no other place of the map fits about as well: four corners of a corridor do.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "libs/places/rival_match.hpp"
#include "libs/scan_matching/scan_refiner.hpp"
#include "libs/scan_matching/thinning.hpp"
#include "services/loop_detector/loop_detector.hpp"

namespace fusion_slam {
namespace {

// What a search on cells and steps of heading may lose against a refined pose.
constexpr double kBetweenCells = 0.8;
constexpr int kSectors = 8;

// Around where the robot was when the submap was made.
std::pair<SE2, double> surroundings(const SubmapStore::Submap& submap, double margin_m) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const SubmapStore::Member& m : submap.members)
    middle += Eigen::Vector2d(m.T_submap_base.x, m.T_submap_base.y);
  middle /= static_cast<double>(submap.members.size());
  double radius_m = 0.0;
  for (const SubmapStore::Member& m : submap.members)
    radius_m =
        std::max(radius_m, (Eigen::Vector2d(m.T_submap_base.x, m.T_submap_base.y) - middle).norm());
  return {SE2{middle.x(), middle.y(), 0.0}, radius_m + margin_m};
}

struct Thinned {
  Points coarse, fine;
};

// A pose apart from `best` where the refined match scores `limit`. The search's own score is of
// cells and steps of heading and loses much against a refined one, so the best of each of eight
// sectors of heading is refined.
std::optional<SE2> rival_in(const UnpackedSubmap& submap, const Thinned& scan, const SE2& middle,
                            double radius_m, const SE2& best, double limit,
                            const LidarCheckConfig& config) {
  const RivalZone zone{config.rival_apart_m, config.rival_apart_rad};
  for (int sector = 0; sector < kSectors; ++sector) {
    const SE2 ahead{middle.x, middle.y, 2.0 * M_PI * sector / kSectors};
    const auto found =
        find_rival(submap.pyramid, scan.coarse, ahead, {radius_m, M_PI / kSectors, 0.0}, best, zone,
                   kBetweenCells * limit);
    if (!found) continue;
    const PosePrior prior{found->T_grid_base, config.prior_sigma_m, config.prior_sigma_rad};
    const SE2 refined =
        refine_match(submap.raster, scan.fine, found->T_grid_base, prior).T_grid_base;
    const SE2 apart = best.inverse() * refined;
    const bool same = std::hypot(apart.x, apart.y) < zone.apart_m &&
                      std::abs(wrap_angle(apart.yaw)) < zone.apart_rad;
    if (!same && match_score(submap.pyramid, scan.coarse, refined) >= limit) return refined;
  }
  return std::nullopt;
}

}  // namespace

// Empty: no rival in the nearest submaps that no edge ties to the scan.
std::string LoopDetector::rival_elsewhere(const LoopScan& scan, const Target& target,
                                          const SE2& T_submap_base) {
  const LidarSearchConfig& config = config_.search;
  const auto T_map_target = graph_.T_map_base({NodeKind::kLidar, target.submap_id});
  const UnpackedSubmap* found_in = submaps_.unpacked(target.submap_id);
  if (!T_map_target || found_in == nullptr) return "the submap is gone";
  const SE2 T_map_base = to_se2(*T_map_target) * T_submap_base;
  const Points coarse = thinned(scan.points_base, config_.lidar.coarse_points);
  const Points fine = thinned(scan.points_base, config_.lidar.fine_points);
  const double limit =
      config_.lidar.rival_score * match_score(found_in->pyramid, coarse, T_submap_base);

  std::vector<std::pair<double, std::int64_t>> nearest;
  for (const auto& [id, submap] : submaps_.all()) {
    const auto T_map_anchor = graph_.T_map_base({NodeKind::kLidar, id});
    if (id >= chain_begins_at_ || submap.members.empty() || submap.tiles.empty() || !T_map_anchor)
      continue;
    nearest.emplace_back((T_map_anchor->translation() - T_map_target->translation()).norm(), id);
  }
  std::sort(nearest.begin(), nearest.end());
  if (nearest.size() > config.most_rival_submaps) nearest.resize(config.most_rival_submaps);
  for (const auto& [distance_m, id] : nearest) {
    const UnpackedSubmap* submap = submaps_.unpacked(id);
    if (submap == nullptr) continue;
    const SE2 T_map_anchor = to_se2(*graph_.T_map_base({NodeKind::kLidar, id}));
    const auto [middle, radius_m] = surroundings(submaps_.all().at(id), config.near_m);
    const auto rival = rival_in(*submap, {coarse, fine}, middle, radius_m,
                                T_map_anchor.inverse() * T_map_base, limit, config_.lidar);
    if (!rival) continue;
    const SE2 apart = T_map_base.inverse() * (T_map_anchor * *rival);
    char text[120];
    std::snprintf(text, sizeof text,
                  "no edge leads here, and it fits as well %.1f m and %.0f degrees away",
                  std::hypot(apart.x, apart.y), std::abs(wrap_angle(apart.yaw)) * 180.0 / M_PI);
    return text;
  }
  return "";
}

}  // namespace fusion_slam
