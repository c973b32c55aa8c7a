#include "services/fuser/insides.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "libs/grid/cell_state.hpp"

namespace fusion_slam {
namespace {

constexpr double kInferred = 0.7;

// States of 3 x 3 tiles; x, y of the centre tile's cells, -64 ... 127.
class Surroundings {
 public:
  Surroundings(const std::map<TileIndex, FusedCells>& fused, const TileIndex& centre) {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const auto it = fused.find({centre.first + dx, centre.second + dy});
        if (it != fused.end()) tiles_[place(dx, dy)] = &it->second.probability;
      }
  }
  CellState at(int x, int y) const {
    const TileCells* tile = tiles_[place(x >> 6, y >> 6)];
    if (tile == nullptr) return CellState::kUnknown;
    return state_of_cell(
        (*tile)[static_cast<std::size_t>(y & 63) * kTileCells + static_cast<std::size_t>(x & 63)]);
  }

 private:
  static std::size_t place(int dx, int dy) {
    const int i = (dy + 1) * 3 + dx + 1;
    return static_cast<std::size_t>(i);
  }
  std::array<const TileCells*, 9> tiles_{};
};
static_assert(kTileCells == 64, "shifts above");

CellState first_verdict(const Surroundings& around, int x, int y, int dx, int dy, int reach) {
  for (int i = 1; i <= reach; ++i) {
    const CellState state = around.at(x + i * dx, y + i * dy);
    if (state != CellState::kUnknown) return state;
  }
  return CellState::kUnknown;
}

bool enclosed(const Surroundings& around, int x, int y, int reach) {
  for (const auto& [dx, dy] :
       {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
    if (first_verdict(around, x, y, dx, dy, reach) != CellState::kOccupied) return false;
  }
  return true;
}

}  // namespace

FusedCells fill_insides(const std::map<TileIndex, FusedCells>& fused, const TileIndex& index,
                        const TileCells& camera, double resolution_m) {
  FusedCells filled = fused.at(index);
  const Surroundings around(fused, index);
  const int reach =
      std::min(kTileCells, static_cast<int>(std::lround(kWidestInside_m / resolution_m)));
  for (int y = 0; y < kTileCells; ++y)
    for (int x = 0; x < kTileCells; ++x) {
      const auto i = static_cast<std::size_t>(y) * kTileCells + static_cast<std::size_t>(x);
      if (camera[i] == kUnknownCell || around.at(x, y) != CellState::kUnknown) continue;
      if (enclosed(around, x, y, reach)) filled.probability[i] = cell_from_probability(kInferred);
    }
  return filled;
}

}  // namespace fusion_slam
