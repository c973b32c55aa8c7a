// How good is a 2D map? Counts cells of an estimated occupancy grid against a reference grid.
// docs/evaluation.md has the definitions in full. Pure functions, callable from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "libs/evaluation/map_class.hpp"
#include "libs/evaluation/outcome.hpp"
#include "libs/evaluation/trajectory.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/grid/cell_state.hpp"
#include "libs/maps/map_raster.hpp"

namespace fusion_slam {

// The motion that takes the estimated map to the reference: the planar part of the least-squares
// SE(3) alignment (Umeyama 1991) of two trajectories of the same frame, matched within max_diff_s;
// of positions on one line, least squares in the plane. Fails for positions in one place.
struct MapAlignment {
  SE2 T_ref_est;
  double tilt_rad = 0.0;  // of the SE(3) alignment's z axis: left out, a levelled map has none
  std::size_t matched = 0;
  double rmse_m = 0.0;  // of the trajectories after alignment
};
Outcome<MapAlignment> align_maps(const Trajectory& reference, const Trajectory& estimate,
                                 double max_diff_s);

// The estimate on the cells of the reference raster grown by `margin` cells on each side wherever
// the estimate reaches further. Each occupied cell of the estimate (cut into equal parts no larger
// than a reference cell) makes the one cell occupied in which its middle lies: no thin wall is
// lost, none grows. Every other cell takes what the estimate has at its middle; occupied there
// counts as unknown, as that obstacle stands in a neighbour already.
struct ResampledMap {
  int first_column = 0;  // of the reference raster, may be negative
  int first_row = 0;
  int width = 0;
  int height = 0;
  std::vector<CellState> cells;

  CellState at(int column, int row) const;  // of the reference; kUnknown outside
};
// Fails when that would be more than 2^27 cells.
Outcome<ResampledMap> resample(const MapRaster& reference, const MapRaster& estimate,
                               const SE2& T_ref_est);

struct ClassScore {
  std::size_t cells = 0;        // occupied cells of the reference
  std::size_t found = 0;        // with an occupied cell of the estimate within the tolerance
  std::size_t called_free = 0;  // not found, and the estimate says free: a robot would hit it
  double recall() const { return cells == 0 ? 0.0 : double(found) / double(cells); }
};

struct MapScore {
  std::size_t estimate_occupied = 0;  // cells, all of them
  std::size_t estimate_right = 0;     // with an occupied reference cell within the tolerance
  std::size_t false_in_free = 0;      // wrong ones where the reference is free
  std::size_t false_in_unknown = 0;   // wrong ones where the reference is unknown
  ClassScore occupied;                // all classes together
  std::array<ClassScore, kObstacleClasses> by_class{};  // index: ObstacleClass
  std::size_t reference_free = 0;                       // cells, but for those below
  std::size_t free_right = 0;                           // the estimate says free
  std::size_t free_wrong = 0;                           // the estimate says occupied
  // Free reference cells within the tolerance of an occupied one that the estimate calls occupied:
  // right by the tolerance, so left out above.
  std::size_t free_excused = 0;

  double precision() const;
  double recall() const { return occupied.recall(); }
  double f1() const;
  double iou() const;            // found / (found + missed + wrong)
  double free_accuracy() const;  // right / (right + wrong)
  double free_coverage() const;  // (right + wrong) / reference_free
};

// tolerance_cells: how far apart (in reference cells, the larger of both axes) two cells may lie
// and still be one; >= 0. classes: ObstacleClass by reference.index(), or empty.
MapScore score_map(const MapRaster& reference, const std::vector<std::uint8_t>& classes,
                   const ResampledMap& estimate, int tolerance_cells);

}  // namespace fusion_slam
