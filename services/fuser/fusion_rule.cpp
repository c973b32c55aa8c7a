#include "services/fuser/fusion_rule.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

// Who is behind the verdict: the sensors that hold it; without a verdict, those that have seen the
// cell. The LiDAR sees one plane: where it says unoccupied, the camera may well see a seat above it
// or a box below it, and that is no conflict. The camera sees the whole band, the LiDAR's plane
// too: where it says unoccupied and the LiDAR occupied, one of them is wrong, or the thing has
// gone.
Provenance provenance_of(std::uint8_t lidar, std::uint8_t camera, CellState verdict) {
  const CellState says_lidar = state_of_cell(lidar);
  const CellState says_camera = state_of_cell(camera);
  if (says_lidar != CellState::kUnknown && says_camera != CellState::kUnknown)
    return says_lidar == says_camera             ? Provenance::kBoth
           : says_camera == CellState::kOccupied ? Provenance::kCamera
                                                 : Provenance::kConflict;
  if (verdict != CellState::kUnknown && says_lidar == verdict) return Provenance::kLidar;
  if (verdict != CellState::kUnknown && says_camera == verdict) return Provenance::kCamera;
  const bool seen_lidar = lidar != kUnknownCell;
  const bool seen_camera = camera != kUnknownCell;
  if (seen_lidar && seen_camera) return Provenance::kBoth;
  if (seen_lidar) return Provenance::kLidar;
  return seen_camera ? Provenance::kCamera : Provenance::kNone;
}

}  // namespace

double fuse_probabilities(double a, double b) {
  const double occupied = a * b;
  const double unoccupied = (1.0 - a) * (1.0 - b);
  const double sum = occupied + unoccupied;
  return sum == 0.0 ? 0.5 : occupied / sum;
}

CellState fuse_states(CellState lidar, CellState camera) {
  if (lidar == CellState::kOccupied || camera == CellState::kOccupied) return CellState::kOccupied;
  if (lidar == CellState::kUnoccupied || camera == CellState::kUnoccupied)
    return CellState::kUnoccupied;
  return CellState::kUnknown;
}

FusedCell fuse_cells(std::uint8_t lidar, std::uint8_t camera) {
  FusedCell fused;
  if (lidar == kUnknownCell && camera == kUnknownCell) return fused;
  const double p_lidar = probability_from_cell(lidar);
  const double p_camera = probability_from_cell(camera);
  double p = fuse_probabilities(p_lidar, p_camera);
  const CellState table = fuse_states(state_of_cell(lidar), state_of_cell(camera));
  if (table == CellState::kOccupied) p = std::max({p, p_lidar, p_camera});
  if (table == CellState::kUnoccupied) p = std::min({p, p_lidar, p_camera});
  fused.probability = cell_from_probability(p);
  fused.state = table == CellState::kUnknown ? state_of_cell(fused.probability) : table;
  fused.provenance = provenance_of(lidar, camera, fused.state);
  return fused;
}

}  // namespace fusion_slam
