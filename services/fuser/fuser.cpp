#include "services/fuser/fuser.hpp"

#include <algorithm>
#include <cmath>

#include "libs/tiles/packed_tile.hpp"
#include "services/fuser/fusion_rule.hpp"
#include "services/fuser/insides.hpp"

namespace fusion_slam {
namespace {

Tile empty_tile(const TileIndex& index, double resolution_m, std::int64_t utime_us) {
  return tile_of_packed(TileEncoding::kEmpty, {0, index.first, index.second, 0}, {}, kTileCells,
                        resolution_m, 0, utime_us);
}

const TileCells* find(const TiledGrid& grid, const TileIndex& index) {
  const auto it = grid.tiles().find(index);
  return it == grid.tiles().end() ? nullptr : &it->second;
}

// How far from free space the cells of an obstacle's face may lie: its own cell, and one for the
// noise. Up to the larger distance occupied cells behind a face are noise; beyond, nobody knows.
constexpr int kFaceCells = 2;
constexpr int kTailCells = 5;

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
  lidar_changed_ = true;
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
  lidar_changed_ = true;
  newest_us_ = std::max(newest_us_, utime_us);
}

bool Fuser::lidar_due() const {
  return lidar_changed_ &&
         (!composed_us_ || newest_us_ >= *composed_us_ + config_.publish_period_us);
}

FuserOutput Fuser::update(bool exact) {
  FuserOutput output;
  const double resolution_m = visual_.resolution_m();
  std::set<TileIndex> changed;
  if (exact || lidar_due()) {
    changed = lidar_.recompose(exact);
    composed_us_ = newest_us_;
    lidar_changed_ = false;
  }
  for (const TileIndex& index : changed) {
    const TileCells* cells = find(lidar_.map(), index);
    Tile tile = cells == nullptr ? empty_tile(index, resolution_m, newest_us_)
                                 : encode_grid_tile({0, index.first, index.second, 0}, *cells,
                                                    resolution_m, 0, newest_us_);
    if (auto fresh = lidar_tiles_.offer(std::move(tile))) output.lidar.push_back(std::move(*fresh));
  }
  std::set<TileIndex> wanted(visual_changed_);
  for (const TileIndex& index : changed)  // a face beside a tile's edge is the next tile's too
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) wanted.insert({index.first + dx, index.second + dy});
  // What encloses an inside may lie in the tile beside it.
  std::set<TileIndex> fill(visual_changed_);
  visual_changed_.clear();
  for (const TileIndex& index : wanted)
    if (refresh_seen(index))
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) fill.insert({index.first + dx, index.second + dy});
  for (const TileIndex& index : fill) {
    const bool seen = seen_.count(index) != 0;
    if (!seen && fused_.erase(index) == 0) continue;
    Tile tile = empty_tile(index, resolution_m, newest_us_);
    if (seen) {
      const TileCells* camera = find(visual_, index);
      const FusedCells cells =
          camera == nullptr ? seen_.at(index) : fill_insides(seen_, index, *camera, resolution_m);
      const auto [held, made] = fused_.try_emplace(index, cells);
      if (!made && held->second == cells) continue;
      held->second = cells;
      tile = encode_fused_tile(tile.key, cells, resolution_m, 0, newest_us_);
    }
    if (auto fresh = fused_tiles_.offer(std::move(tile))) output.fused.push_back(std::move(*fresh));
  }
  return output;
}

bool Fuser::refresh_seen(const TileIndex& index) {
  if (find(lidar_.map(), index) == nullptr && find(visual_, index) == nullptr)
    return seen_.erase(index) != 0;
  FusedCells cells = fuse_tile(index);
  const auto [held, made] = seen_.try_emplace(index, cells);
  if (!made && held->second == cells) return false;
  held->second = cells;
  return true;
}

bool Fuser::free_near(const TileCells& cells, const TileIndex& index, int x, int y,
                      int reach) const {
  for (int yy = y - reach; yy <= y + reach; ++yy)
    for (int xx = x - reach; xx <= x + reach; ++xx) {
      const bool inside = xx >= 0 && yy >= 0 && xx < kTileCells && yy < kTileCells;
      const std::uint8_t cell =
          inside ? cells[static_cast<std::size_t>(yy) * kTileCells + static_cast<std::size_t>(xx)]
                 : lidar_.map().at(index.first * kTileCells + xx, index.second * kTileCells + yy);
      if (state_of_cell(cell) == CellState::kUnoccupied) return true;
    }
  return false;
}

// The LiDAR's cell; without a verdict where it says occupied just behind the face of an obstacle:
// nothing can be seen through the face, so that is the noise of ranges.
std::uint8_t Fuser::lidar_cell(const TileCells& cells, const TileIndex& index, int x, int y) const {
  const std::uint8_t cell =
      cells[static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x)];
  if (state_of_cell(cell) != CellState::kOccupied || free_near(cells, index, x, y, kFaceCells) ||
      !free_near(cells, index, x, y, kTailCells))
    return cell;
  return cell_from_probability(0.5);
}

FusedCells Fuser::fuse_tile(const TileIndex& index) const {
  const TileCells* lidar = find(lidar_.map(), index);
  const TileCells* camera = find(visual_, index);
  FusedCells fused;
  for (std::size_t i = 0; i < fused.probability.size(); ++i) {
    const int x = static_cast<int>(i % kTileCells), y = static_cast<int>(i / kTileCells);
    const FusedCell cell =
        fuse_cells(lidar == nullptr ? kUnknownCell : lidar_cell(*lidar, index, x, y),
                   camera == nullptr ? kUnknownCell : (*camera)[i]);
    fused.probability[i] = cell.probability;
    fused.provenance[i] = static_cast<std::uint8_t>(cell.provenance);
  }
  return fused;
}

}  // namespace fusion_slam
