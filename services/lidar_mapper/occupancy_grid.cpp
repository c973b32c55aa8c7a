#include "services/lidar_mapper/occupancy_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace fusion_slam {
namespace {

int thousandths_of_log_odds(double probability) {
  return static_cast<int>(std::lround(1000.0 * std::log(probability / (1.0 - probability))));
}

}  // namespace

OccupancyGrid::OccupancyGrid(double resolution_m, const LidarMapperConfig& config)
    : hit_(thousandths_of_log_odds(config.hit_probability)),
      miss_(thousandths_of_log_odds(config.miss_probability)),
      lowest_(thousandths_of_log_odds(config.min_probability)),
      highest_(thousandths_of_log_odds(config.max_probability)),
      cells_(resolution_m),
      raster_(resolution_m, kUnknownCell) {
  for (int l = lowest_; l <= highest_; ++l)
    byte_of_.push_back(cell_from_probability(1.0 / (1.0 + std::exp(-l / 1000.0))));
}

void OccupancyGrid::update(int x, int y, int change) {
  Cell& cell = cells_.cell(x, y);
  if (cell.last_scan == scan_) return;
  cell.last_scan = scan_;
  cell.log_odds = static_cast<std::int16_t>(std::clamp(cell.log_odds + change, lowest_, highest_));
  raster_.cell(x, y) = byte_of_[static_cast<std::size_t>(cell.log_odds - lowest_)];
}

void OccupancyGrid::miss_between(CellIndex from, CellIndex to) {
  const int dx = std::abs(to.x - from.x), dy = std::abs(to.y - from.y);
  const int step_x = to.x > from.x ? 1 : -1, step_y = to.y > from.y ? 1 : -1;
  int error = dx - dy;
  for (CellIndex c = from; c.x != to.x || c.y != to.y;) {
    update(c.x, c.y, miss_);
    const int twice = 2 * error;
    if (twice > -dy) error -= dy, c.x += step_x;
    if (twice < dx) error += dx, c.y += step_y;
  }
}

void OccupancyGrid::insert(const Eigen::Vector2d& origin, const Points& hits,
                           const Points& surface) {
  if (hits.empty()) return;
  ++scan_;
  const CellIndex start = cells_.cell_of(origin.x(), origin.y());
  CellIndex low = start, high = start;
  std::vector<CellIndex> ends;
  ends.reserve(hits.size());
  for (const auto& p : hits) {
    const CellIndex c = cells_.cell_of(p.x(), p.y());
    low = {std::min(low.x, c.x), std::min(low.y, c.y)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y)};
    ends.push_back(c);
  }
  cells_.include(low, high);
  raster_.include(low, high);
  for (const CellIndex& c : ends) update(c.x, c.y, hit_);
  for (const auto& p : surface) {  // between end points, so inside
    const CellIndex c = cells_.cell_of(p.x(), p.y());
    update(c.x, c.y, hit_);
  }
  for (const CellIndex& c : ends) miss_between(start, c);
  // Which tiles a scan touched: those with a cell that carries its number.
  for (int ty = tile_floor(low.y); ty <= high.y; ty += kTileCells)
    for (int tx = tile_floor(low.x); tx <= high.x; tx += kTileCells) {
      const TileIndex index{tx / kTileCells, ty / kTileCells};
      if (changed_.count(index) != 0) continue;
      bool touched = false;
      for (int y = ty; y < ty + kTileCells && !touched; ++y)
        touched = std::any_of(cells_.row(y) + (tx - cells_.min_x()),
                              cells_.row(y) + (tx - cells_.min_x()) + kTileCells,
                              [this](const Cell& cell) { return cell.last_scan == scan_; });
      if (touched) changed_.insert(index);
    }
}

TileCells OccupancyGrid::tile(const TileIndex& index) const {
  TileCells out;
  for (int y = 0; y < kTileCells; ++y)
    std::copy_n(
        raster_.row(index.second * kTileCells + y) + (index.first * kTileCells - raster_.min_x()),
        kTileCells, out.begin() + y * kTileCells);
  return out;
}

}  // namespace fusion_slam
