#include "services/dense_mapper/compose.hpp"

#include <algorithm>
#include <cmath>

#include "libs/octree/octomap_tile.hpp"

namespace fusion_slam {
namespace {

// floor() for numbers well within +-2^20, without a library call.
inline int fast_floor(double v) { return static_cast<int>(v + 1048576.0) - 1048576; }

struct Range {
  Eigen::Array3d low = Eigen::Array3d::Constant(1e9);
  Eigen::Array3d high = Eigen::Array3d::Constant(-1e9);

  void include(const Eigen::Vector3d& p) {
    low = low.min(p.array());
    high = high.max(p.array());
  }
  bool overlaps(const Range& other) const {
    return (low <= other.high).all() && (other.low <= high).all();
  }
};

Range range_of(const VoxelBlocks& voxels) {
  Range range;
  for (const auto& [index, block] : voxels.blocks()) {
    const Eigen::Vector3d low = Eigen::Vector3d(index.x, index.y, index.z) * kBlockVoxels;
    range.include(low);
    range.include(low + Eigen::Vector3d::Constant(kBlockVoxels));
  }
  return range;
}

Eigen::Vector3d corner(int i, const Eigen::Vector3d& low, const Eigen::Vector3d& size) {
  const Eigen::Vector3d which(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  return low + which.cwiseProduct(size);
}

}  // namespace

std::vector<std::int8_t> compose_voxels(const DenseSubmaps& submaps, const LatticeBox& box,
                                        const DenseMapperConfig& config) {
  const std::int8_t low_step = log_odds_to_step(config.log_odds_min);
  const std::int8_t high_step = log_odds_to_step(config.log_odds_max);
  const auto volume = static_cast<std::size_t>(box.size.prod());
  std::vector<std::int16_t> sum(volume, kUnknownLogOdds);
  for (const auto& [id, submap] : submaps) {
    const SE3 T_submap_map = submap.T_map_submap.inverse();
    Range wanted;
    for (int i = 0; i < 8; ++i)
      wanted.include(T_submap_map *
                     corner(i, box.low_m, box.size.cast<double>() * box.resolution_m) /
                     box.resolution_m);
    if (!wanted.overlaps(range_of(submap.voxels))) continue;
    // In voxels of the submap: the first centre, and the way from one to the next along each axis.
    const Eigen::Vector3d first = T_submap_map *
                                  (box.low_m + Eigen::Vector3d::Constant(box.resolution_m / 2)) /
                                  box.resolution_m;
    const Eigen::Matrix3d axes = T_submap_map.linear();
    VoxelReader reader(submap.voxels);
    std::size_t i = 0;
    for (int z = 0; z < box.size.z(); ++z) {
      for (int y = 0; y < box.size.y(); ++y) {
        const Eigen::Vector3d row = first + axes.col(1) * y + axes.col(2) * z;
        for (int x = 0; x < box.size.x(); ++x, ++i) {
          const Eigen::Vector3d p = row + axes.col(0) * x;
          const std::int16_t steps =
              reader.at(fast_floor(p.x()), fast_floor(p.y()), fast_floor(p.z()));
          if (steps == kUnknownLogOdds) continue;
          sum[i] = add_steps(sum[i], std::clamp<int>(steps, low_step, high_step));
        }
      }
    }
  }
  std::vector<std::int8_t> out(volume);
  for (std::size_t i = 0; i < volume; ++i)
    out[i] = sum[i] == kUnknownLogOdds
                 ? kUnknownVoxel
                 : static_cast<std::int8_t>(std::clamp<int>(sum[i], low_step, high_step));
  return out;
}

std::map<TileKey, std::vector<ColouredPoint>> compose_cloud(const DenseSubmaps& submaps,
                                                            const std::set<TileKey>& keys,
                                                            double cloud_resolution_m) {
  std::map<TileKey, std::vector<ColouredPoint>> gathered;
  for (const auto& [id, submap] : submaps) {
    for (ColouredPoint& point : submap.cloud.points()) {
      const Eigen::Vector3d p_map = submap.T_map_submap * point.p_m.cast<double>();
      const TileKey key = cloud_tile_of(0, p_map, cloud_resolution_m);
      if (keys.count(key) == 0) continue;
      point.p_m = p_map.cast<float>();
      gathered[key].push_back(point);
    }
  }
  for (auto& [key, points] : gathered) {
    VoxelCloud thinned(cloud_resolution_m);
    thinned.add(points);
    points = thinned.points();
  }
  return gathered;
}

TileRange tiles_of_block(const BlockIndex& block, double resolution_m, const SE3& T_map_submap,
                         double edge_m) {
  const double block_m = kBlockVoxels * resolution_m;
  const Eigen::Vector3d low_m = Eigen::Vector3d(block.x, block.y, block.z) * block_m;
  Range range;
  for (int i = 0; i < 8; ++i)
    range.include(T_map_submap * corner(i, low_m, Eigen::Vector3d::Constant(block_m)));
  TileRange tiles;
  tiles.low = (range.low / edge_m).floor().cast<int>();
  tiles.high = (range.high / edge_m).floor().cast<int>();
  return tiles;
}

}  // namespace fusion_slam
