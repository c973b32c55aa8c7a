// One grid in the map frame out of many small ones, each rigid in its submap's frame and placed by
// the pose graph. A loop closure moves anchors and never needs the scans again. Each map cell looks
// its centre up in every submap that covers it (inverse lookup: no holes); what they say is
// combined by equation 7 of the paper, which in log-odds is a sum. Submaps are visited by id, so
// the result does not depend on the order in which anything arrived. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "libs/geometry/pose.hpp"
#include "libs/grid/tiled_grid.hpp"

namespace fusion_slam {

class GridComposer {
 public:
  // A submap is placed anew when a point of it has moved more than `slack_cells`.
  explicit GridComposer(double resolution_m, double slack_cells = 0.25);

  // A tile of a submap, replacing the older one; a submap's resolution is that of its first tile.
  void set_tile(std::int64_t submap_id, const TileIndex& index, const TileCells& cells,
                double resolution_m);
  void erase_tile(std::int64_t submap_id, const TileIndex& index);
  void set_pose(std::int64_t submap_id, const SE2& T_map_submap);

  // Brings map() up to date; returns the map's tiles that were computed again. `exact` places every
  // submap where the graph says now, without slack.
  std::set<TileIndex> recompose(bool exact);

  // Tiles in which no cell is known are absent.
  const TiledGrid& map() const { return map_; }

 private:
  struct Submap {
    std::optional<TiledGrid> grid;
    std::optional<SE2> T_map_submap;  // the graph's
    std::optional<SE2> placed;        // the one in map()
    std::set<TileIndex> changed;      // its own tiles since recompose()
    std::set<TileIndex> covers;       // the map's tiles that it touches as placed
  };
  bool needs_placing(const Submap& submap, bool exact) const;
  void mark(const Submap& submap, const TileIndex& own, std::set<TileIndex>* dirty) const;
  void compose_tile(const TileIndex& index);

  TiledGrid map_;
  double slack_m_;
  std::map<std::int64_t, Submap> submaps_;
};

}  // namespace fusion_slam
