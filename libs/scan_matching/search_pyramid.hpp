// Upper bounds for blocks of translations, at three scales, so that a correlative search can
// discard most of its window (Olson 2009, "Real-time correlative scan matching"; Hess et al. 2016,
// section V).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {

// One decimated level. bound(i, j) is the largest match byte of the cells [s i, s (i + 2)) x [s j,
// s (j + 2)), s the stride: an upper bound for a point in block (i, j) that moves by 0 .. s cells.
class PyramidLevel {
 public:
  PyramidLevel(int stride, int min_x, int min_y, int width, int height);

  int stride() const { return stride_; }
  std::uint8_t bound(int block_x, int block_y) const {
    const unsigned x = static_cast<unsigned>(block_x - min_x_);
    const unsigned y = static_cast<unsigned>(block_y - min_y_);
    if (x >= static_cast<unsigned>(width_) || y >= static_cast<unsigned>(height_)) return outside_;
    return cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + x];
  }

 private:
  friend class SearchPyramid;
  int stride_, min_x_, min_y_, width_, height_;
  std::uint8_t outside_;
  std::vector<std::uint8_t> cells_;
};

// A snapshot: the raster may change or go afterwards. Reading is safe from any thread.
class SearchPyramid {
 public:
  static constexpr int kLevels = 3;
  static constexpr std::array<int, kLevels> kStrides{1, 4, 16};

  explicit SearchPyramid(const Raster& raster);

  double resolution_m() const { return resolution_m_; }
  const PyramidLevel& level(int index) const { return levels_[static_cast<std::size_t>(index)]; }

 private:
  double resolution_m_;
  std::vector<PyramidLevel> levels_;
};

// Match probability in bytes: 255 * match_probability().
std::uint8_t match_byte(std::uint8_t cell);

}  // namespace fusion_slam
