#include "libs/scan_matching/search_pyramid.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

int floor_div(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

std::array<std::uint8_t, 256> make_match_bytes() {
  std::array<std::uint8_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<std::uint8_t>(std::lround(255.0 * match_probability()[i]));
  return table;
}

// Each block of `factor` x `factor` cells becomes their largest.
std::vector<std::uint8_t> block_max(const std::vector<std::uint8_t>& fine, int width, int height,
                                    int factor) {
  const int coarse_width = width / factor;
  std::vector<std::uint8_t> coarse(
      static_cast<std::size_t>(coarse_width) * static_cast<std::size_t>(height / factor), 0);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* in = fine.data() + static_cast<std::ptrdiff_t>(y) * width;
    std::uint8_t* out = coarse.data() + static_cast<std::ptrdiff_t>(y / factor) * coarse_width;
    for (int x = 0; x < coarse_width; ++x)
      for (int k = 0; k < factor; ++k) out[x] = std::max(out[x], in[x * factor + k]);
  }
  return coarse;
}

}  // namespace

std::uint8_t match_byte(std::uint8_t cell) {
  static const std::array<std::uint8_t, 256> table = make_match_bytes();
  return table[cell];
}

PyramidLevel::PyramidLevel(int stride, int min_x, int min_y, int width, int height)
    : stride_(stride),
      min_x_(min_x),
      min_y_(min_y),
      width_(width),
      height_(height),
      outside_(match_byte(kUnknownCell)),
      cells_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), outside_) {}

SearchPyramid::SearchPyramid(const Raster& raster) : resolution_m_(raster.resolution_m()) {
  std::array<std::uint8_t, 256> lookup{};
  for (std::size_t i = 0; i < lookup.size(); ++i)
    lookup[i] = match_byte(static_cast<std::uint8_t>(i));

  PyramidLevel finest(1, raster.min_x(), raster.min_y(), raster.width(), raster.height());
  for (int y = 0; y < raster.height(); ++y)
    std::transform(raster.row(raster.min_y() + y), raster.row(raster.min_y() + y) + raster.width(),
                   finest.cells_.begin() + static_cast<std::ptrdiff_t>(y) * raster.width(),
                   [&](std::uint8_t cell) { return lookup[cell]; });

  std::vector<std::uint8_t> blocks = finest.cells_;
  int width = finest.width_, height = finest.height_;
  levels_.push_back(std::move(finest));
  for (std::size_t i = 1; i < kStrides.size(); ++i) {
    const int factor = kStrides[i] / kStrides[i - 1];
    blocks = block_max(blocks, width, height, factor);  // sizes are multiples of a tile's edge
    width /= factor, height /= factor;
    // One block more on the low side: a point there can move into the raster.
    PyramidLevel level(kStrides[i], floor_div(raster.min_x(), kStrides[i]) - 1,
                       floor_div(raster.min_y(), kStrides[i]) - 1, width + 1, height + 1);
    const auto block = [&](int x, int y) {
      if (x < 0 || y < 0 || x >= width || y >= height) return level.outside_;
      return blocks[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x)];
    };
    for (int y = 0; y <= height; ++y)
      for (int x = 0; x <= width; ++x)
        level.cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width + 1) +
                     static_cast<std::size_t>(x)] =
            std::max(std::max(block(x - 1, y - 1), block(x, y - 1)),
                     std::max(block(x - 1, y), block(x, y)));
    levels_.push_back(std::move(level));
  }
}

}  // namespace fusion_slam
