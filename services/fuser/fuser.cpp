#include "services/fuser/fuser.hpp"

#include <algorithm>
#include <cmath>

#include "services/fuser/fusion_rule.hpp"

namespace fusion_slam {
namespace {

Tile empty_tile(const TileIndex& index, double resolution_m, std::int64_t utime_us) {
  Tile tile;
  tile.key = {0, index.first, index.second, 0};
  tile.resolution_m = resolution_m;
  tile.size_cells = kTileCells;
  tile.utime_us = utime_us;
  return tile;
}

const TileCells* find(const TiledGrid& grid, const TileIndex& index) {
  const auto it = grid.tiles().find(index);
  return it == grid.tiles().end() ? nullptr : &it->second;
}

}  // namespace

Fuser::Fuser(double resolution_m, const FuserConfig& config)
    : config_(config), lidar_(resolution_m, config.slack_cells), visual_(resolution_m) {}

bool Fuser::add_submap_tile(const Tile& tile) {
  const TileIndex index{tile.key.x, tile.key.y};
  if (tile.encoding == TileEncoding::kEmpty) {
    lidar_.erase_tile(tile.key.submap_id, index);
  } else {
    const auto cells = decode_grid_tile(tile);
    if (!cells || !(tile.resolution_m > 1e-3 && tile.resolution_m < 10.0)) return false;
    lidar_.set_tile(tile.key.submap_id, index, *cells, tile.resolution_m);
  }
  newest_us_ = std::max(newest_us_, tile.utime_us);
  return true;
}

bool Fuser::add_visual_tile(const Tile& tile) {
  const TileIndex index{tile.key.x, tile.key.y};
  if (tile.encoding == TileEncoding::kEmpty) {
    visual_.tiles().erase(index);
  } else {
    const auto cells = decode_grid_tile(tile);
    if (!cells || std::abs(tile.resolution_m - visual_.resolution_m()) > 1e-9) return false;
    visual_.tiles()[index] = *cells;
  }
  visual_changed_.insert(index);
  newest_us_ = std::max(newest_us_, tile.utime_us);
  return true;
}

void Fuser::set_anchor(std::int64_t submap_id, const SE3& T_map_submap, std::int64_t utime_us) {
  lidar_.set_pose(submap_id, to_se2(T_map_submap));
  newest_us_ = std::max(newest_us_, utime_us);
}

bool Fuser::due() const {
  return !published_us_ || newest_us_ >= *published_us_ + config_.publish_period_us;
}

FuserOutput Fuser::update(bool exact) {
  FuserOutput output;
  const double resolution_m = visual_.resolution_m();
  std::set<TileIndex> changed = lidar_.recompose(exact);
  for (const TileIndex& index : changed) {
    const TileCells* cells = find(lidar_.map(), index);
    Tile tile = cells == nullptr ? empty_tile(index, resolution_m, newest_us_)
                                 : encode_grid_tile({0, index.first, index.second, 0}, *cells,
                                                    resolution_m, 0, newest_us_);
    if (auto fresh = lidar_tiles_.offer(std::move(tile))) output.lidar.push_back(std::move(*fresh));
  }
  changed.insert(visual_changed_.begin(), visual_changed_.end());
  visual_changed_.clear();
  for (const TileIndex& index : changed) {
    const bool seen = find(lidar_.map(), index) != nullptr || find(visual_, index) != nullptr;
    Tile tile = !seen ? empty_tile(index, resolution_m, newest_us_)
                      : encode_fused_tile({0, index.first, index.second, 0}, fuse_tile(index),
                                          resolution_m, 0, newest_us_);
    if (auto fresh = fused_tiles_.offer(std::move(tile))) output.fused.push_back(std::move(*fresh));
  }
  published_us_ = newest_us_;
  return output;
}

FusedCells Fuser::fuse_tile(const TileIndex& index) const {
  const TileCells* lidar = find(lidar_.map(), index);
  const TileCells* camera = find(visual_, index);
  FusedCells fused;
  for (std::size_t i = 0; i < fused.probability.size(); ++i) {
    const FusedCell cell = fuse_cells(lidar == nullptr ? kUnknownCell : (*lidar)[i],
                                      camera == nullptr ? kUnknownCell : (*camera)[i]);
    fused.probability[i] = cell.probability;
    fused.provenance[i] = static_cast<std::uint8_t>(cell.provenance);
  }
  return fused;
}

}  // namespace fusion_slam
