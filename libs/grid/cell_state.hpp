// When a cell counts as occupied or unoccupied: the thresholds of the ROS map_server format, so
// that a map file shows exactly the states that fusion decided on.
#pragma once

#include <cstdint>

#include "libs/grid/tiled_grid.hpp"

namespace fusion_slam {

constexpr double kOccupiedAbove = 0.65;
constexpr double kFreeBelow = 0.25;

enum class CellState : std::uint8_t { kUnknown, kUnoccupied, kOccupied };

// kUnknown: never seen, or seen without a verdict (between the thresholds).
inline CellState state_of_probability(double p) {
  if (p > kOccupiedAbove) return CellState::kOccupied;
  if (p < kFreeBelow) return CellState::kUnoccupied;
  return CellState::kUnknown;
}
inline CellState state_of_cell(std::uint8_t cell) {
  return cell == kUnknownCell ? CellState::kUnknown
                              : state_of_probability(probability_from_cell(cell));
}

}  // namespace fusion_slam
