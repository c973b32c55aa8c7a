// Log-odds occupancy of one submap (paper, equations 3-5; adding log-odds is equation 7), and the
// bytes that scans are matched against and tiles are made of.
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "libs/scan_matching/raster.hpp"
#include "services/lidar_mapper/config.hpp"

namespace fusion_slam {

class OccupancyGrid {
 public:
  OccupancyGrid(double resolution_m, const LidarMapperConfig& config);

  // Each end point's cell and each cell of `surface` is hit once, each other cell between origin
  // and end point missed once, however many beams meet it: a scan is one measurement of a cell.
  // Metres, in the grid's frame.
  void insert(const Eigen::Vector2d& origin, const Points& hits, const Points& surface = {});

  const Raster& raster() const { return raster_; }
  const std::set<TileIndex>& changed_tiles() const { return changed_; }
  void forget_changes() { changed_.clear(); }
  TileCells tile(const TileIndex& index) const;

 private:
  struct Cell {
    std::int16_t log_odds = 0;    // in thousandths
    std::uint16_t last_scan = 0;  // number of the scan that changed it last
  };
  void update(int x, int y, int change);
  void miss_between(CellIndex from, CellIndex to);

  int hit_, miss_, lowest_, highest_;  // log-odds in thousandths
  std::vector<std::uint8_t> byte_of_;  // by log-odds - lowest
  DenseGrid<Cell> cells_;
  Raster raster_;
  std::uint16_t scan_ = 0;
  std::set<TileIndex> changed_;
};

}  // namespace fusion_slam
