#include "libs/scan_matching/raster.hpp"

namespace fusion_slam {
namespace {

// A wall that three scans have seen is as much a wall as one that thirty have. Without this a scan
// is drawn to where the robot has been longest: backwards, in a corridor.
constexpr double kSureProbability = 0.8;

std::array<float, 256> make_match_probability() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const auto byte = static_cast<std::uint8_t>(i);
    const double p = byte == kUnknownCell ? kUnknownMatchProbability : probability_from_cell(byte);
    table[i] = static_cast<float>(std::clamp(p / kSureProbability, kUnknownMatchProbability, 0.98));
  }
  return table;
}

}  // namespace

const std::array<float, 256>& match_probability() {
  static const std::array<float, 256> table = make_match_probability();
  return table;
}

Raster raster_from_tiles(const TiledGrid& grid) {
  Raster raster(grid.resolution_m(), kUnknownCell);
  for (const auto& [index, cells] : grid.tiles()) {
    const int x0 = index.first * kTileCells;
    const int y0 = index.second * kTileCells;
    raster.include({x0, y0}, {x0 + kTileCells - 1, y0 + kTileCells - 1});
  }
  for (const auto& [index, cells] : grid.tiles())
    for (int y = 0; y < kTileCells; ++y)
      std::copy_n(cells.begin() + y * kTileCells, kTileCells,
                  &raster.cell(index.first * kTileCells, index.second * kTileCells + y));
  return raster;
}

}  // namespace fusion_slam
