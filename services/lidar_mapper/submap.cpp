#include "services/lidar_mapper/submap.hpp"

#include <iterator>
#include <utility>

namespace fusion_slam {
namespace {

void append(std::vector<Tile>& all, std::vector<Tile> more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

Submap::Submap(std::int64_t anchor_node_id, const SE2& T_odom_submap, double resolution_m,
               const LidarMapperConfig& config)
    : id_(anchor_node_id),
      T_odom_submap_(T_odom_submap),
      grid_(resolution_m, config),
      surfaces_(2.0 * resolution_m) {}

void Submap::insert(const ScanPoints& scan, const SE2& T_odom_base, std::int64_t utime_us) {
  const SE2 T_submap_base = T_odom_submap_.inverse() * T_odom_base;
  const auto placed = [&](const Points& points) {
    Points out;
    out.reserve(points.size());
    for (const auto& p : points) out.push_back(T_submap_base * p);
    return out;
  };
  const Points hits = placed(scan.hits_base);
  grid_.insert(T_submap_base * scan.origin_base, hits, placed(scan.surface_base));
  Points normals = scan.sweep.normals;
  const Eigen::Rotation2Dd turn(T_submap_base.yaw);
  for (auto& n : normals) n = turn * n;
  normals.resize(hits.size(), Eigen::Vector2d::Zero());
  surfaces_.add(hits, normals);
  newest_us_ = std::max(newest_us_, utime_us);
  ++n_scans_;
}

std::vector<Tile> Submap::take_changed_tiles() {
  std::vector<Tile> tiles;
  for (const TileIndex& index : grid_.changed_tiles())
    tiles.push_back(encode_grid_tile({id_, index.first, index.second, 0}, grid_.tile(index),
                                     grid_.raster().resolution_m(), ++revisions_[index],
                                     newest_us_));
  grid_.forget_changes();
  return tiles;
}

std::vector<Tile> ActiveSubmaps::insert(std::int64_t node_id, const ScanPoints& scan,
                                        const SE2& T_odom_base, std::int64_t utime_us) {
  if (submaps_.empty() || submaps_.back().n_scans() >= config_.nodes_per_half_submap)
    submaps_.emplace_back(node_id, T_odom_base, resolution_m_, config_);
  inserted_into_.clear();
  for (Submap& submap : submaps_) {
    submap.insert(scan, T_odom_base, utime_us);
    inserted_into_.push_back({submap.id(), submap.T_odom_submap().inverse() * T_odom_base});
  }
  return finish_full();
}

std::vector<Tile> ActiveSubmaps::finish_full() {
  if (submaps_.empty() || submaps_.front().n_scans() < 2 * config_.nodes_per_half_submap) return {};
  std::vector<Tile> last = submaps_.front().take_changed_tiles();
  submaps_.erase(submaps_.begin());
  return last;
}

std::vector<Tile> ActiveSubmaps::take_changed_tiles() {
  std::vector<Tile> tiles;
  for (Submap& submap : submaps_) append(tiles, submap.take_changed_tiles());
  return tiles;
}

std::vector<Tile> ActiveSubmaps::finish_all() {
  std::vector<Tile> tiles = take_changed_tiles();
  submaps_.clear();
  return tiles;
}

}  // namespace fusion_slam
