// One grid in the map frame out of many small ones, each rigid in its submap's frame and placed by
// the pose graph. A loop closure moves anchors and never needs the scans again. Each map cell looks
// its centre up in every submap that covers it (inverse lookup: no holes); what they say is
// combined by equation 7 of the paper, in log-odds a sum, from the oldest submap to the newest and
// clamped at each step: a few new observations outweigh however many old ones, so what has been
// moved away goes. The result does not depend on the order in which anything arrived.
// Fast because it computes little: only the cells that a change can reach, on top of what the older
// submaps of a tile say together, which is remembered. Small because submaps that no longer grow
// are kept deflated, a tenth of their size. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/grid/tiled_grid.hpp"

namespace fusion_slam {

// Cells [x0, x1) x [y0, y1) of a tile.
struct CellBox {
  int x0 = kTileCells;
  int y0 = kTileCells;
  int x1 = 0;
  int y1 = 0;

  bool empty() const { return x0 >= x1 || y0 >= y1; }
  void include(const CellBox& other);
};

class GridMosaic {
 public:
  // A submap is placed anew when a point of it has moved more than `slack_cells`.
  explicit GridMosaic(double resolution_m, double slack_cells = 0.25);

  // A tile of a submap, replacing the older one; a submap's resolution is that of its first tile.
  void set_tile(std::int64_t submap_id, const TileIndex& index, const TileCells& cells,
                double resolution_m);
  void erase_tile(std::int64_t submap_id, const TileIndex& index);
  void set_pose(std::int64_t submap_id, const SE2& T_map_submap);

  // Brings map() up to date; returns the map's tiles whose cells changed. `exact` places every
  // submap where the graph says now, without slack.
  std::set<TileIndex> recompose(bool exact);

  // Tiles in which no cell is known are absent.
  const TiledGrid& map() const { return map_; }

  std::size_t submap_bytes() const;  // what the submaps' cells take

 private:
  // A tile as it came, or deflated.
  struct Cells {
    std::unique_ptr<TileCells> open;  // null: packed
    std::vector<std::uint8_t> packed;
  };
  struct Grid {
    double resolution_m = 0.0;
    std::map<TileIndex, Cells> tiles;
  };
  struct Submap {
    std::optional<Grid> grid;
    std::optional<SE2> T_map_submap;       // the graph's
    std::optional<SE2> placed;             // the one in map()
    std::map<TileIndex, CellBox> changed;  // of its own tiles, since recompose()
    std::set<TileIndex> covers;            // the map's tiles that it touches as placed
  };
  using Sums = std::vector<std::int16_t>;  // of a tile's cells, kNothing where unknown
  struct Base {                            // what the submaps with id < upto say of a map tile
    std::int64_t upto = 0;
    Sums sums;
  };
  using Dirty = std::map<TileIndex, CellBox>;  // of map()

  bool needs_placing(const Submap& submap, bool exact) const;
  void mark(std::int64_t id, const Submap& submap, const TileIndex& own, const CellBox& cells,
            Dirty* dirty);
  void cover(Submap* submap);
  static void open(Cells* cells);
  void pack_old();
  bool compose_tile(const TileIndex& index, const CellBox& box);
  void add(const Submap& submap, const TileIndex& index, const CellBox& box, Sums* sums) const;

  TiledGrid map_;
  double slack_m_;
  std::map<std::int64_t, Submap> submaps_;
  std::set<std::int64_t> open_;                             // those of submaps_ that are not packed
  std::map<TileIndex, std::set<std::int64_t>> covered_by_;  // of map(), by submaps
  std::map<TileIndex, Base> bases_;
};

}  // namespace fusion_slam
