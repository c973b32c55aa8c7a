// What the closed submaps say together, cube by cube of the map, kept packed: a keyframe then only
// has to be laid over it, however many submaps the place has seen. Submaps are added in the order
// of their ids, so the result does not depend on when anything arrived. Not thread-safe.
#pragma once

#include <bitset>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "services/dense_mapper/compose.hpp"
#include "services/dense_mapper/dense_submap.hpp"

namespace fusion_slam {

class BaseMap {
 public:
  BaseMap(double resolution_m, double cloud_resolution_m, const StepBounds& bounds);

  // Adds a closed submap, as placed, whose id is above all that were added.
  void extend(const DenseSubmap& submap);
  // These cubes have changed below: composed anew, of all closed submaps with id < upto, voxels
  // and points. Both are to be done before the next extend().
  void rebuild_cells(const std::set<CubeIndex>& cubes, const DenseSubmaps& submaps,
                     std::int64_t upto);
  void rebuild_points(const std::set<CubeIndex>& cubes, const DenseSubmaps& submaps,
                      std::int64_t upto);

  // All unknown where nothing is. The reference is valid until the next call of a non-const
  // function.
  const VoxelCells& cells(const CubeIndex& index);
  // One point a voxel, of the submap with the lowest id that has one there; map frame.
  std::vector<ColouredPoint> points(const TileKey& key) const;
  // Tiles of the cloud that hold points, and their packed content.
  const PackedCloud& clouds() const { return clouds_; }
  // Packed content of the cubes that hold known voxels.
  const PackedCubes& cubes() const { return cubes_; }

  // Cubes and tiles of the cloud that were written since the last call.
  std::set<CubeIndex> take_changed_cubes() { return std::exchange(changed_cubes_, {}); }
  std::set<TileKey> take_changed_clouds() { return std::exchange(changed_clouds_, {}); }
  void restore(PackedCubes cubes, PackedCloud clouds);  // as an earlier process had them

  void forget_unpacked() {  // memory for time
    hot_.clear();
    hot_clouds_.clear();
  }
  std::size_t size_bytes() const;  // of what is kept packed

 private:
  // A tile of the cloud at work: its points and which voxels they are in.
  struct OpenTile {
    std::vector<ColouredPoint> points;
    std::bitset<kOctomapTileVolume> taken;
    bool changed = false;
  };
  using OpenTiles = std::map<TileKey, OpenTile>;
  OpenTile& open(const TileKey& key, OpenTiles* tiles) const;
  void add_points(const std::vector<ColouredPoint>& points_submap, const SE3& T_map_submap,
                  const std::set<TileKey>* only, OpenTiles* tiles) const;
  void pack(OpenTiles* tiles);

  double resolution_m_;
  double cloud_resolution_m_;
  StepBounds bounds_;
  PackedCubes cubes_;
  PackedCloud clouds_;
  VoxelCubes hot_;                                            // unpacked, of cubes_
  std::map<TileKey, std::vector<ColouredPoint>> hot_clouds_;  // of clouds_
  std::set<CubeIndex> changed_cubes_;
  std::set<TileKey> changed_clouds_;
};

// Where a point of tile `key` lies in its 32^3 voxels: 0 ... 32767; of clouds with this voxel size.
std::size_t cloud_voxel_of(const TileKey& key, const Eigen::Vector3d& p_m, double resolution_m);

// The 8 tiles of the cloud that fill a cube of the map: cloud voxels have half its voxels' edge.
std::array<TileKey, 8> cloud_tiles_of(const CubeIndex& cube);

}  // namespace fusion_slam
