#include "services/dense_mapper/compose.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "services/dense_mapper/base_map.hpp"
#include "services/dense_mapper/supersede.hpp"

namespace fusion_slam {
namespace {

constexpr double kResolution = 0.05;
constexpr StepBounds kBounds{-64, 112};

// Closed submaps of random voxels, and a cloud of random points, about the map's origin.
DenseSubmaps random_submaps(int n) {
  std::mt19937 random(6);
  DenseSubmaps submaps;
  for (int id = 1; id <= n; ++id) {
    DenseSubmap& submap = submaps.emplace(id, DenseSubmap(kResolution / 2)).first->second;
    std::vector<ColouredPoint> points(500);
    for (int i = 0; i < 20000; ++i)
      submap.voxels.add(static_cast<int>(random() % 40) - 20, static_cast<int>(random() % 40) - 20,
                        static_cast<int>(random() % 40) - 20,
                        static_cast<int>(random() % 200) - 100);
    for (ColouredPoint& point : points)
      for (int axis = 0; axis < 3; ++axis)
        point.p_m[axis] = static_cast<float>(random() % 2000) * 1e-3F - 1.0F;
    submap.cloud.add(points);
    for (const auto& [index, block] : submap.voxels.blocks())
      copy_block(index, block, kBounds.low, kBounds.high, &submap.cubes);
    submap.T_map_submap = from_xyz_rpy(0.2 * id, -0.1 * id, 0.05, 0.3 * id, 0.1, 0.7 * id);
    close_submap(kResolution, &submap);
  }
  return submaps;
}

std::int8_t at(const VoxelCubes& cubes, const Eigen::Vector3d& p_voxels) {
  const Eigen::Array3i v = p_voxels.array().floor().cast<int>();
  const auto it = cubes.find({v.x() >> 5, v.y() >> 5, v.z() >> 5});
  return it == cubes.end() ? kUnknownVoxel
                           : (*it->second)[voxel_index(v.x() & 31, v.y() & 31, v.z() & 31)];
}

TEST(Compose, EqualsLookingUpEachVoxelAlone) {
  const DenseSubmaps submaps = random_submaps(3);
  for (const CubeIndex& cube : {CubeIndex{0, 0, 0}, CubeIndex{-1, -1, -1}, CubeIndex{0, -1, 0}}) {
    VoxelCells fast;
    fast.fill(kUnknownVoxel);
    VoxelCells slow = fast;
    for (const auto& [id, submap] : submaps) {
      const VoxelCubes cubes = unpack_cubes(submap.packed);
      const SE3 T_submap_map = submap.T_map_submap.inverse();
      add_submap(cubes, T_submap_map, cube, kResolution, kBounds, {3, 29}, &fast);
      for (int z = 3; z < 29; ++z)
        for (int y = 0; y < 32; ++y)
          for (int x = 0; x < 32; ++x) {
            const Eigen::Vector3d centre(32 * cube.x + x + 0.5, 32 * cube.y + y + 0.5,
                                         32 * cube.z + z + 0.5);
            std::int8_t& sum = slow[voxel_index(x, y, z)];
            sum = add_clamped(sum, at(cubes, T_submap_map * (centre * kResolution) / kResolution),
                              kBounds.low, kBounds.high);
          }
    }
    std::size_t known = 0;
    std::size_t different = 0;
    for (std::size_t i = 0; i < fast.size(); ++i) {
      known += slow[i] == kUnknownVoxel ? 0 : 1;
      different += fast[i] == slow[i] ? 0 : 1;
    }
    EXPECT_GT(known, 300U);
    EXPECT_LE(different, 5U);  // a centre on a face may round to either side
  }
}

TEST(Compose, BoxesTouchTheCubesOfTheirPoints) {
  const SE3 T = from_xyz_rpy(0.3, -2.0, 1.0, 0.4, 0.2, 1.0);
  const Eigen::Vector3d low(-1.6, 0.8, 0.0);
  std::set<CubeIndex> touched;
  insert_touched(low, low + Eigen::Vector3d::Constant(0.8), T, 1.6, &touched);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(0.0, 0.8);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p =
        low + Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
    const Eigen::Array3i cube = ((T * p) / 1.6).array().floor().cast<int>();
    EXPECT_EQ(touched.count({cube.x(), cube.y(), cube.z()}), 1U);
  }
}

// Unpacked or not, the cubes that can't be reached change nothing.
TEST(Compose, OnlyCubesThatMayTouchAreUnpacked) {
  const DenseSubmaps submaps = random_submaps(3);
  std::size_t left_out = 0;
  for (const auto& [id, submap] : submaps) {
    const VoxelCubes all = unpack_cubes(submap.packed);
    for (const CubeIndex& cube : submap.touches) {
      const VoxelCubes some =
          unpack_touching(submap.packed, submap.T_map_submap, kResolution, {cube});
      left_out += all.size() - some.size();
      VoxelCells of_all, of_some;
      of_all.fill(kUnknownVoxel);
      of_some.fill(kUnknownVoxel);
      const SE3 T_submap_map = submap.T_map_submap.inverse();
      add_submap(all, T_submap_map, cube, kResolution, kBounds, SliceRange{}, &of_all);
      add_submap(some, T_submap_map, cube, kResolution, kBounds, SliceRange{}, &of_some);
      EXPECT_TRUE(of_all == of_some);
    }
  }
  EXPECT_GT(left_out, 0U);
}

void rebuild(BaseMap* map, const std::set<CubeIndex>& cubes, const DenseSubmaps& submaps,
             std::int64_t upto) {
  map->rebuild_cells(cubes, submaps, upto);
  map->rebuild_points(cubes, submaps, upto);
}

TEST(BaseMap, ExtendingEqualsRebuilding) {
  const DenseSubmaps submaps = random_submaps(4);
  BaseMap grown(kResolution, kResolution / 2, kBounds);
  std::set<CubeIndex> cubes;
  for (const auto& [id, submap] : submaps) {
    grown.extend(submap);
    cubes.insert(submap.touches.begin(), submap.touches.end());
  }
  BaseMap built(kResolution, kResolution / 2, kBounds);
  rebuild(&built, cubes, submaps, 100);
  std::size_t points = 0;
  for (const CubeIndex& cube : cubes) {
    EXPECT_TRUE(grown.cells(cube) == built.cells(cube));
    for (const TileKey& key : cloud_tiles_of(cube)) points += built.points(key).size();
  }
  EXPECT_GT(points, 1000U);
  EXPECT_EQ(grown.clouds(), built.clouds());
  EXPECT_EQ(grown.size_bytes(), built.size_bytes());
  grown.forget_unpacked();
  rebuild(&grown, {*cubes.begin()}, submaps, 100);
  EXPECT_EQ(grown.clouds(), built.clouds());
  EXPECT_EQ(grown.cubes(), built.cubes());
  for (const auto& [key, bytes] : built.clouds()) {
    const auto hot = built.points(key);
    const auto unpacked = unpack_cloud({{key, bytes}}, kResolution / 2);
    ASSERT_EQ(hot.size(), unpacked.size());
    for (std::size_t i = 0; i < hot.size(); ++i) EXPECT_EQ(hot[i].p_m, unpacked[i].p_m);
  }
  rebuild(&built, cubes, submaps, 1);  // of none
  EXPECT_EQ(built.size_bytes(), 0U);
}

TEST(BaseMap, RebuildingAPartInTwoStepsEqualsRebuildingAll) {
  DenseSubmaps submaps = random_submaps(5);
  BaseMap map(kResolution, kResolution / 2, kBounds);
  std::set<CubeIndex> all;
  for (const auto& [id, submap] : submaps) {
    map.extend(submap);
    all.insert(submap.touches.begin(), submap.touches.end());
  }
  DenseSubmap& moved = submaps.at(2);
  std::set<CubeIndex> changed(moved.touches.begin(), moved.touches.end());
  moved.T_map_submap = from_xyz_rpy(1.7, 0.4, 0.1, 0.0, 0.1, 1.9);
  const std::set<CubeIndex> touched = touched_cubes(moved, kResolution);
  moved.touches.assign(touched.begin(), touched.end());
  changed.insert(touched.begin(), touched.end());
  all.insert(touched.begin(), touched.end());
  map.rebuild_cells(changed, submaps, 100);
  map.rebuild_points(changed, submaps, 100);
  BaseMap fresh(kResolution, kResolution / 2, kBounds);
  for (const auto& [id, submap] : submaps) fresh.extend(submap);
  EXPECT_LT(changed.size(), all.size());
  EXPECT_EQ(map.clouds(), fresh.clouds());
  EXPECT_EQ(map.cubes(), fresh.cubes());
}

TEST(BaseMap, OnePointAVoxelAndEachInItsTile) {
  DenseSubmaps submaps = random_submaps(2);
  BaseMap map(kResolution, kResolution / 2, kBounds);
  for (const auto& [id, submap] : submaps) map.extend(submap);
  for (const auto& [key, bytes] : map.clouds()) {
    std::set<std::size_t> voxels;
    for (const ColouredPoint& point : map.points(key)) {
      EXPECT_EQ(cloud_tile_of(0, point.p_m.cast<double>(), kResolution / 2), key);
      voxels.insert(cloud_voxel_of(key, point.p_m.cast<double>(), kResolution / 2));
    }
    // Rounding to 1/65536 of the tile may move a point over a face.
    EXPECT_GE(voxels.size() + 2, map.points(key).size());
  }
}

TEST(DenseSubmap, OpensAgainAsItWasClosed) {
  DenseSubmaps submaps = random_submaps(1);
  DenseSubmap& submap = submaps.at(1);
  const PackedCubes packed = submap.packed;
  open_submap(&submap);
  EXPECT_FALSE(submap.closed);
  EXPECT_GT(submap.voxels.blocks().size(), 0U);
  EXPECT_GT(submap.cloud.size(), 400U);
  close_submap(kResolution, &submap);
  EXPECT_EQ(submap.packed, packed);
}

// The same place again and again: what is kept stops growing.
TEST(Supersede, OldVoxelsGoWhenEnoughNewerOnesKnowThem) {
  DenseSubmaps submaps;
  std::size_t most = 0;
  for (int id = 1; id <= 40; ++id) {
    DenseSubmap& submap = submaps.emplace(id, DenseSubmap(kResolution / 2)).first->second;
    for (int i = 0; i < 1000; ++i) submap.voxels.add(i % 10, i / 10 % 10, i / 100, 50);
    for (const auto& [index, block] : submap.voxels.blocks())
      copy_block(index, block, kBounds.low, kBounds.high, &submap.cubes);
    ColouredPoint point;
    point.p_m = {0.21F, 0.22F, 0.23F};
    submap.cloud.add({point});
    close_submap(kResolution, &submap);
    std::set<std::int64_t> counted;
    if (const std::int64_t old = count_newer(id, 8, &submaps, &counted))
      drop_superseded(old, 4, kResolution, kResolution / 2, &submaps);
    std::size_t held = 0;
    for (const auto& [other, s] : submaps) held += s.packed.empty() ? 0 : 1;
    most = std::max(most, held);
  }
  EXPECT_LE(most, 9U);
  EXPECT_TRUE(submaps.at(1).packed.empty());
  EXPECT_TRUE(submaps.at(1).packed_cloud.empty());
  EXPECT_FALSE(submaps.at(40).packed.empty());
}

TEST(Supersede, WhatOnlyTheOldOneKnowsStays) {
  DenseSubmaps submaps;
  for (int id = 1; id <= 9; ++id) {
    DenseSubmap& submap = submaps.emplace(id, DenseSubmap(kResolution / 2)).first->second;
    for (int x = 0; x < (id == 1 ? 20 : 10); ++x) submap.voxels.add(x, 0, 0, 50);
    for (const auto& [index, block] : submap.voxels.blocks())
      copy_block(index, block, kBounds.low, kBounds.high, &submap.cubes);
    close_submap(kResolution, &submap);
  }
  EXPECT_FALSE(drop_superseded(1, 4, kResolution, kResolution / 2, &submaps));
  const VoxelCubes left = unpack_cubes(submaps.at(1).packed);
  for (int x = 0; x < 20; ++x)
    EXPECT_EQ(at(left, Eigen::Vector3d(x + 0.5, 0.5, 0.5)), x < 10 ? kUnknownVoxel : 50) << x;
}

}  // namespace
}  // namespace fusion_slam
