// The raster map: the OctoMap projected along z between floor clearance and robot height, with free
// space and with honest unknowns.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "libs/grid/tiled_grid.hpp"
#include "libs/octree/octomap_tile.hpp"

namespace fusion_slam {

// One column of voxels of the band, log-odds in steps (kUnknownVoxel: never seen), to the byte of
// its cell:
// - occupied as its most occupied voxel, when that one is more likely occupied than not;
// - else free by the mean of all voxels, where one that was never seen counts as half occupied
//   (log-odds 1), so that a column with more than about a quarter unseen stays without a verdict;
// - unknown when none was seen.
std::uint8_t raster_cell(const std::vector<std::int8_t>& column);

// Voxels of the lattice along z: [from, to), those whose centres lie between the two heights; one
// at least.
struct Band {
  int from = 0;
  int to = 1;
};
Band band_between(double low_m, double high_m, double resolution_m);

constexpr std::size_t kColumnCells =
    static_cast<std::size_t>(kOctomapTileVoxels) * kOctomapTileVoxels;
using ColumnCells = std::array<std::uint8_t, kColumnCells>;  // row-major: [y * 32 + x]

// The band over 32 x 32 cells: raster_cell for all of them at a time.
class ColumnRaster {
 public:
  ColumnRaster();
  // Cubes from the band's lowest to its highest; slices [from, to) of each. first: the band's voxel
  // that slice `from` is.
  void add(const VoxelCells& cube, int from_slice, int to_slice, int first);
  // Without overhangs. band_voxels: of the whole band, also those in cubes that weren't added.
  std::uint8_t cell(std::size_t i, int band_voxels) const;

  // Voxels of cell i by height, bit 0 the band's lowest. What lies beyond the 32nd has no bit.
  std::uint32_t occupied(std::size_t i) const { return occupied_[i]; }
  std::uint32_t known(std::size_t i) const { return known_[i]; }

 private:
  std::array<std::int8_t, kColumnCells> highest_;
  std::array<std::int16_t, kColumnCells> sum_;
  std::array<std::int16_t, kColumnCells> seen_;
  std::array<std::uint32_t, kColumnCells> occupied_;
  std::array<std::uint32_t, kColumnCells> known_;
};

using ColumnIndex = std::pair<int, int>;  // cube x, y
using ColumnRasters = std::map<ColumnIndex, ColumnRaster>;

// Cells of a column, with overhangs: of a seat or a table top near the camera's own height only the
// rim is seen, never what lies within it, and not its underside, which is too flat for the camera.
// A voxel that was never seen counts as occupied (with p = 0.7) when free space was seen below it,
// 10 cm at least, and along x or y nothing but unseen voxels lies between it and a rim (an occupied
// voxel with free space below it, which no wall and no box on the floor has) at most 0.45 m away:
// on both sides; on one side is enough where free space was seen above it too. Columns beside it
// are looked up in `rasters`.
ColumnCells raster_column(const ColumnRasters& rasters, const ColumnIndex& index, int band_voxels,
                          double resolution_m);

}  // namespace fusion_slam
