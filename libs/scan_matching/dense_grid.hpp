// A rectangle of cells in one piece of memory, addressed by signed cell indices as TiledGrid's are:
// cell (i, j) covers [i, i+1) x [j, j+1) times resolution_m. Grows by whole tiles. Not thread-safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "libs/grid/tiled_grid.hpp"

namespace fusion_slam {

struct CellIndex {
  int x = 0;
  int y = 0;
};

// The largest multiple of the tile's edge that is not above `cell`.
inline int tile_floor(int cell) {
  return (cell >= 0 ? cell : cell - kTileCells + 1) / kTileCells * kTileCells;
}

template <class Cell>
class DenseGrid {
 public:
  explicit DenseGrid(double resolution_m, Cell outside = Cell{})
      : resolution_m_(resolution_m), outside_(outside) {}

  double resolution_m() const { return resolution_m_; }
  int min_x() const { return min_x_; }
  int min_y() const { return min_y_; }
  int width() const { return width_; }
  int height() const { return height_; }
  bool contains(int x, int y) const {
    return static_cast<unsigned>(x - min_x_) < static_cast<unsigned>(width_) &&
           static_cast<unsigned>(y - min_y_) < static_cast<unsigned>(height_);
  }

  // `outside` beyond the rectangle.
  Cell at(int x, int y) const { return contains(x, y) ? cells_[offset(x, y)] : outside_; }

  // Only for cells that contains() says are there.
  Cell& cell(int x, int y) { return cells_[offset(x, y)]; }
  const Cell* row(int y) const { return cells_.data() + offset(min_x_, y); }

  CellIndex cell_of(double x_m, double y_m) const {
    return {static_cast<int>(std::floor(x_m / resolution_m_)),
            static_cast<int>(std::floor(y_m / resolution_m_))};
  }

  // Grows the rectangle, tile by tile, until both cells (low corner, high corner) are inside.
  void include(CellIndex low, CellIndex high) {
    if (width_ > 0 && contains(low.x, low.y) && contains(high.x, high.y)) return;
    int x0 = tile_floor(low.x), y0 = tile_floor(low.y);
    int x1 = tile_floor(high.x) + kTileCells, y1 = tile_floor(high.y) + kTileCells;
    if (width_ > 0) {
      x0 = std::min(x0, min_x_), y0 = std::min(y0, min_y_);
      x1 = std::max(x1, min_x_ + width_), y1 = std::max(y1, min_y_ + height_);
    }
    std::vector<Cell> grown(static_cast<std::size_t>(x1 - x0) * static_cast<std::size_t>(y1 - y0),
                            outside_);
    for (int y = min_y_; y < min_y_ + height_; ++y)
      std::copy_n(row(y), width_,
                  grown.begin() + static_cast<std::ptrdiff_t>(y - y0) * (x1 - x0) + (min_x_ - x0));
    cells_ = std::move(grown);
    min_x_ = x0, min_y_ = y0, width_ = x1 - x0, height_ = y1 - y0;
  }

 private:
  std::size_t offset(int x, int y) const {
    return static_cast<std::size_t>(y - min_y_) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x - min_x_);
  }

  double resolution_m_;
  Cell outside_;
  int min_x_ = 0;
  int min_y_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<Cell> cells_;
};

}  // namespace fusion_slam
