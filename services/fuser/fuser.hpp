// Fuses the LiDAR's submaps and the camera's grid into one map (Yu et al. 2025, section 3.1). Tile
// by tile: only tiles whose input changed are computed again, and the result is the same as from
// scratch. Either sensor may be absent. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/grid/fused_tile.hpp"
#include "libs/submaps/changed_tiles.hpp"
#include "libs/submaps/grid_composer.hpp"
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

  // True when enough has happened (in the inputs' time) to publish again.
  bool due() const;
  // compose -> fuse -> what changed. `exact` places submaps without slack: for the final map.
  FuserOutput update(bool exact);

 private:
  FusedCells fuse_tile(const TileIndex& index) const;

  FuserConfig config_;
  GridComposer lidar_;
  TiledGrid visual_;
  std::set<TileIndex> visual_changed_;
  std::int64_t newest_us_ = 0;
  std::optional<std::int64_t> published_us_;
  ChangedTiles lidar_tiles_;
  ChangedTiles fused_tiles_;
};

}  // namespace fusion_slam
