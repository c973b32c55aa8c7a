// From submaps to tiles: what the dense mapper says of the cubes and columns that changed.
#include <algorithm>
#include <cmath>

#include "libs/tiles/packed_tile.hpp"
#include "services/dense_mapper/dense_mapper.hpp"

namespace fusion_slam {
namespace {

constexpr int kEdge = kOctomapTileVoxels;

// A point is a ghost when its voxel is free and no voxel beside it is occupied: what stood there
// has gone since. Only the point's own cube is asked, so that a tile depends on one cube.
bool is_ghost(const VoxelCells& cube, const Eigen::Array3i& voxel) {
  const std::int8_t own = cube[voxel_index(voxel.x(), voxel.y(), voxel.z())];
  if (own == kUnknownVoxel || own >= 0) return false;
  const Eigen::Array3i low = (voxel - 1).max(0);
  const Eigen::Array3i high = (voxel + 1).min(kEdge - 1);
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x)
        if (cube[voxel_index(x, y, z)] >= 0) return false;
  return true;
}

}  // namespace

// The base with the open submaps on top, in the order of their ids.
DenseMapper::Composed DenseMapper::compose(const std::set<CubeIndex>& cubes,
                                           const SliceRange& slices) {
  Composed composed;
  for (const CubeIndex& cube : cubes) composed.emplace(cube, base_.cells(cube));
  for (auto it = submaps_.lower_bound(base_upto_); it != submaps_.end(); ++it) {
    const DenseSubmap& submap = it->second;
    VoxelCubes unpacked;
    if (submap.closed) unpacked = unpack_cubes(submap.packed);
    const VoxelCubes& voxels = submap.closed ? unpacked : submap.cubes;
    const SE3 T_submap_map = submap.T_map_submap.inverse();
    for (auto& [cube, cells] : composed)
      add_submap(voxels, T_submap_map, cube, robot_.map_resolution_m, step_bounds(config_), slices,
                 &cells);
  }
  return composed;
}

void DenseMapper::publish_octomap(const Composed& composed, std::vector<Tile>* out) {
  for (const auto& [cube, cells] : composed) {
    const TileKey key{0, cube.x, cube.y, cube.z};
    // Where nothing lies over the base its packed content is the tile's.
    const auto base = base_.cubes().find(cube);
    const bool same = base != base_.cubes().end() && cells == base_.cells(cube);
    auto tile = octomap_tiles_.offer(octomap_tile_of(key, same ? base->second : pack_cells(cells),
                                                     robot_.map_resolution_m, 0, newest_us_));
    if (tile) out->push_back(std::move(*tile));
  }
}

void DenseMapper::publish_clouds(const Composed& composed, std::vector<Tile>* out) {
  const double resolution_m = robot_.map_resolution_m / 2;
  for (const auto& [cube, cells] : composed) {
    for (const TileKey& key : cloud_tiles_of(cube)) {
      std::vector<ColouredPoint> points = base_.points(key);
      const auto ghost = [&, &cube = cube, &cells = cells](const ColouredPoint& point) {
        const Eigen::Array3i voxel =
            (point.p_m.cast<double>() / robot_.map_resolution_m).array().floor().cast<int>();
        const Eigen::Array3i corner(cube.x * kEdge, cube.y * kEdge, cube.z * kEdge);
        return is_ghost(cells, (voxel - corner).max(0).min(kEdge - 1));
      };
      const auto gone = std::remove_if(points.begin(), points.end(), ghost);
      const auto base = base_.clouds().find(key);
      const bool same = base != base_.clouds().end() && gone == points.end();
      points.erase(gone, points.end());
      auto tile = cloud_tiles_.offer(
          same ? cloud_tile_of_packed(key, base->second, resolution_m, 0, newest_us_)
               : encode_cloud_tile(key, points, resolution_m, 0, newest_us_));
      if (tile) out->push_back(std::move(*tile));
    }
  }
}

// A submap of a tilted camera has tilted voxels: the floor's reach up to a voxel's diagonal above
// it.
Band DenseMapper::band() const {
  const double r = robot_.map_resolution_m;
  const double clearance_m =
      robot_.planar ? robot_.floor_clearance_m : std::max(robot_.floor_clearance_m, 2.0 * r);
  return band_between(clearance_m, std::max(robot_.robot_height_m, clearance_m + r), r);
}

void DenseMapper::publish_grid(std::vector<Tile>* out) {
  const Band band = this->band();
  const auto cube_z = [](int voxel) { return voxel >> 5; };
  for (const auto& column : dirty_columns_) columns_[column] = ColumnRaster();
  for (int z = cube_z(band.from); z <= cube_z(band.to - 1); ++z) {
    std::set<CubeIndex> cubes;
    for (const auto& [x, y] : dirty_columns_) cubes.insert({x, y, z});
    const SliceRange slices{std::max(0, band.from - z * kEdge),
                            std::min(kEdge, band.to - z * kEdge)};
    for (const auto& [cube, cells] : compose(cubes, slices))
      columns_.at({cube.x, cube.y})
          .add(cells, slices.from, slices.to, z * kEdge + slices.from - band.from);
  }
  // An overhang may reach into the columns beside it.
  Columns around;
  for (const auto& [x, y] : dirty_columns_)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (columns_.count({x + dx, y + dy}) != 0) around.insert({x + dx, y + dy});
  std::set<TileIndex> changed;
  for (const ColumnIndex& column : around) {
    const TileIndex index{column.first >> 1, column.second >> 1};
    const auto [it, made] = grid_.tiles().try_emplace(index);
    if (made) it->second.fill(kUnknownCell);
    const ColumnCells cells =
        raster_column(columns_, column, band.to - band.from, robot_.map_resolution_m);
    const int x0 = (column.first & 1) * kEdge;
    const int y0 = (column.second & 1) * kEdge;
    for (int y = 0; y < kEdge; ++y) {
      const auto* from = cells.data() + static_cast<std::size_t>(y) * kEdge;
      auto* to = it->second.data() + static_cast<std::size_t>(y0 + y) * kTileCells + x0;
      if (std::equal(from, from + kEdge, to)) continue;
      std::copy(from, from + kEdge, to);
      changed.insert(index);
    }
  }
  dirty_columns_.clear();
  for (const TileIndex& index : changed) {
    const TileCells& cells = grid_.tiles().at(index);
    const bool known = std::any_of(cells.begin(), cells.end(),
                                   [](std::uint8_t cell) { return cell != kUnknownCell; });
    const TileKey key{0, index.first, index.second, 0};
    const double resolution_m = robot_.map_resolution_m;
    Tile tile = known ? encode_grid_tile(key, cells, resolution_m, 0, newest_us_)
                      : tile_of_packed(TileEncoding::kEmpty, key, {}, kTileCells, resolution_m, 0,
                                       newest_us_);
    if (auto fresh = grid_tiles_.offer(std::move(tile))) out->push_back(std::move(*fresh));
  }
}

}  // namespace fusion_slam
