// An unbounded 2D grid of bytes kept as 64 x 64 tiles. Cell (i, j) covers [i, i+1) x [j, j+1) times
// resolution_m; x grows with i, y with j. A cell's byte is a probability of occupied: 0 unknown,
// else (value - 1) / 254.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "libs/tiles/tile.hpp"

namespace fusion_slam {

constexpr int kTileCells = 64;
constexpr std::uint8_t kUnknownCell = 0;

// Probability in [0, 1] to a cell's byte in 1..255 and back; an unknown cell counts as 0.5.
inline std::uint8_t cell_from_probability(double p) {
  const double clamped = p < 0.0 ? 0.0 : (p > 1.0 ? 1.0 : p);
  return static_cast<std::uint8_t>(1 + std::lround(clamped * 254.0));
}
inline double probability_from_cell(std::uint8_t cell) {
  return cell == kUnknownCell ? 0.5 : (cell - 1) / 254.0;
}

using TileIndex = std::pair<int, int>;  // (tile x, tile y) = floor(cell / 64)
using TileCells = std::array<std::uint8_t, kTileCells * kTileCells>;  // row-major: [y * 64 + x]

class TiledGrid {
 public:
  explicit TiledGrid(double resolution_m) : resolution_m_(resolution_m) {}

  double resolution_m() const { return resolution_m_; }
  std::uint8_t at(int cell_x, int cell_y) const;         // kUnknownCell where there is no tile
  void set(int cell_x, int cell_y, std::uint8_t value);  // makes the tile when needed
  int cell_of(double coordinate_m) const {
    return static_cast<int>(std::floor(coordinate_m / resolution_m_));
  }

  const std::map<TileIndex, TileCells>& tiles() const { return tiles_; }
  std::map<TileIndex, TileCells>& tiles() { return tiles_; }

 private:
  double resolution_m_;
  std::map<TileIndex, TileCells> tiles_;
};

// One tile of a grid for the wire (encoding kGridProbability), and back. Decoding gives nothing
// when the tile's encoding, size or data are not what encode_grid_tile makes.
Tile encode_grid_tile(const TileKey& key, const TileCells& cells, double resolution_m,
                      std::int64_t revision, std::int64_t utime_us);
std::optional<TileCells> decode_grid_tile(const Tile& tile);

}  // namespace fusion_slam
