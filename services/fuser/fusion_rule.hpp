// How one cell of the LiDAR grid and one of the camera grid become one: equation 8 and Table 1 of
// Yu et al. 2025. Pure functions, symmetric in the two sensors (but for the names in the
// provenance).
#pragma once

#include <cstdint>

#include "libs/grid/cell_state.hpp"
#include "libs/grid/fused_tile.hpp"

namespace fusion_slam {

// Equation 8: P = a b / (a b + (1 - a)(1 - b)), 0.5 where the two contradict each other with
// certainty (0 and 1).
double fuse_probabilities(double a, double b);

// Table 1: occupied wins, then unoccupied; unknown only when both are.
CellState fuse_states(CellState lidar, CellState camera);

struct FusedCell {
  std::uint8_t probability = kUnknownCell;
  CellState state = CellState::kUnknown;
  Provenance provenance = Provenance::kNone;
};

// A cell's bytes as in tiled_grid.hpp; unknown counts as 0.5. The probability is equation 8's,
// moved only as far as Table 1 demands: where the table says occupied it is not below either
// sensor's, where it says unoccupied not above either's, so the probability alone always shows the
// table's state. Two cells that were seen without a verdict are unknown to the table: there the
// thresholds judge the fused probability, as the paper does below equation 7.
FusedCell fuse_cells(std::uint8_t lidar, std::uint8_t camera);

}  // namespace fusion_slam
