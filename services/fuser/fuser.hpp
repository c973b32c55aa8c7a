// Fuses the LiDAR's submaps and the camera's grid into one map (Yu et al. 2025, section 3.1). Tile
// by tile: only tiles whose input changed are computed again, and the result is the same as from
// scratch. Either sensor may be absent. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/grid/fused_tile.hpp"
#include "libs/grid/grid_mosaic.hpp"
#include "libs/submaps/changed_tiles.hpp"
#include "libs/tiles/tile.hpp"
#include "services/fuser/config.hpp"

namespace fusion_slam {

struct FuserOutput {
  std::vector<Tile> lidar;  // GRID_LIDAR: changed tiles, revisions set
  std::vector<Tile> fused;  // GRID_FUSED
};

class Fuser {
 public:
  Fuser(double resolution_m, const FuserConfig& config);

  // A SUBMAP tile: encoding kGridProbability, or kEmpty when it is gone. False: damaged, ignored.
  bool add_submap_tile(const Tile& tile);
  // A GRID_VISUAL tile (submap_id 0, map frame, this map's resolution), likewise.
  bool add_visual_tile(const Tile& tile);
  // Where the graph has the LiDAR node that a submap hangs on.
  void set_anchor(std::int64_t submap_id, const SE3& T_map_submap, std::int64_t utime_us);

  // True when there is something to publish: the camera's tiles at once, the LiDAR's submaps once
  // in a publish_period_us of the inputs' time.
  bool due() const { return !visual_changed_.empty() || lidar_due(); }
  // compose -> fuse -> what changed. `exact` composes what isn't due yet, and places submaps
  // without slack: for the final map.
  FuserOutput update(bool exact);

 private:
  bool lidar_due() const;
  FusedCells fuse_tile(const TileIndex& index) const;
  bool refresh_seen(const TileIndex& index);  // true: changed
  bool free_near(const TileCells& cells, const TileIndex& index, int x, int y, int reach) const;
  std::uint8_t lidar_cell(const TileCells& cells, const TileIndex& index, int x, int y) const;

  FuserConfig config_;
  GridMosaic lidar_;
  TiledGrid visual_;
  std::set<TileIndex> visual_changed_;
  std::int64_t newest_us_ = 0;
  bool lidar_changed_ = false;
  std::optional<std::int64_t> composed_us_;  // the LiDAR's submaps
  ChangedTiles lidar_tiles_;
  std::map<TileIndex, FusedCells> seen_;   // by Table 1 and equation 8
  std::map<TileIndex, FusedCells> fused_;  // as published: insides filled
  ChangedTiles fused_tiles_;
};

}  // namespace fusion_slam
