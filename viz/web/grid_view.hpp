// What the three grids say of one cell, and since when: answers a click. Tiles in, no items out
// (tiles go to browsers as they are). Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "libs/grid/fused_tile.hpp"
#include "libs/tiles/tile.hpp"

namespace fusion_slam {

struct CellReport {
  double resolution_m = 0.05;
  int cell_x = 0;  // of the whole map
  int cell_y = 0;
  std::optional<double> fused;  // probability of occupied; nothing: unknown
  std::optional<double> lidar;
  std::optional<double> visual;
  Provenance provenance = Provenance::kNone;
  std::int64_t first_seen_us =
      0;  // of the fused cell (the LiDAR's or camera's where there is no fused grid); 0: never
  std::int64_t last_changed_us = 0;  // when its value last changed
  int changes = 0;                   // since this viewer listens
};

class GridView {
 public:
  enum class Layer { kFused, kLidar, kVisual };

  // False for a tile that is damaged or of a submap.
  bool on_tile(Layer layer, const Tile& tile);
  // The cell at a place in the map, metres. Nothing where no tile is.
  std::optional<CellReport> at(double x_m, double y_m) const;
  double known_area_m2() const;  // of the fused grid, else the LiDAR's, else the camera's
  void clear() { *this = GridView(); }

 private:
  struct History {
    std::int64_t first_us = 0;
    std::int64_t changed_us = 0;
    std::int32_t changes = 0;
  };
  struct Cells {
    FusedCells cells;
    std::int64_t revision = 0;
    double resolution_m = 0.05;
    int known = 0;
    std::array<History, kTileCells * kTileCells> history{};
  };
  using Tiles = std::map<TileIndex, Cells>;
  const Tiles* best() const;

  std::array<Tiles, 3> layers_;
};

}  // namespace fusion_slam
