// Stage 3 on drawn rooms, and the store of submaps that it looks into.
#include "services/loop_detector/lidar_check.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "services/loop_detector/submap_store.hpp"

namespace fusion_slam {
namespace {

constexpr double kCell_m = 0.05;
constexpr std::uint8_t kFree = 20, kWall = 230;

// Free inside, walls around: x in [-3, 3], y in [-2, 2]; `open_ends`: a corridor without end walls;
// otherwise a pillar makes its two halves different.
TiledGrid room(bool open_ends) {
  TiledGrid grid(kCell_m);
  for (int x = -62; x <= 62; ++x)
    for (int y = -42; y <= 42; ++y) grid.set(x, y, kFree);
  for (int x = -62; x <= 62; ++x)
    for (const int y : {-41, -40, 40, 41}) grid.set(x, y, kWall);
  if (open_ends) return grid;
  for (int y = -42; y <= 42; ++y)
    for (const int x : {-61, -60, 60, 61}) grid.set(x, y, kWall);
  for (int x = 30; x < 38; ++x)
    for (int y = 18; y < 26; ++y) grid.set(x, y, kWall);
  return grid;
}

// End points on the walls, told in the frame of a robot at T; every eighth metre of wall.
Points scan_from(const TiledGrid& grid, const SE2& T) {
  Points points;
  for (int i = 0; i < 360; ++i) {
    const double a = i * M_PI / 180.0;
    for (double r = 0.3; r < 6.0; r += 0.01) {
      const Eigen::Vector2d p = T * Eigen::Vector2d(r * std::cos(a), r * std::sin(a));
      if (grid.at(grid.cell_of(p.x()), grid.cell_of(p.y())) != kWall) continue;
      points.emplace_back((r + 0.02) * std::cos(a), (r + 0.02) * std::sin(a));
      break;
    }
  }
  return points;
}

UnpackedSubmap unpacked(const TiledGrid& grid) {
  const Raster raster = raster_from_tiles(grid);
  return {raster, SearchPyramid(raster)};
}

TEST(LidarCheck, FindsTheScanWhereItWasTaken) {
  const TiledGrid grid = room(false);
  const SE2 truth{0.6, -0.4, 0.3};
  const LidarCheck check =
      check_scan(unpacked(grid), scan_from(grid, truth), {0.3, -0.1, 0.2}, {0.8, 0.3, 0.02}, {});
  ASSERT_EQ(check.opinion, LidarOpinion::kFits) << check.reason;
  EXPECT_NEAR(check.T_submap_base.x, truth.x, 0.03);
  EXPECT_NEAR(check.T_submap_base.y, truth.y, 0.03);
  EXPECT_NEAR(check.T_submap_base.yaw, truth.yaw, 0.01);
  EXPECT_GT(check.score, 0.7);
  EXPECT_LT(check.covariance(0, 0), 0.1 * 0.1);
}

TEST(LidarCheck, ACorridorDoesNotSayHowFarAlong) {
  const TiledGrid grid = room(true);
  const LidarCheck check =
      check_scan(unpacked(grid), scan_from(grid, {0.5, 0.1, 0.0}), {0, 0, 0}, {0.8, 0.3, 0.02}, {});
  EXPECT_EQ(check.opinion, LidarOpinion::kNothing) << check.reason;
}

TEST(LidarCheck, SeesKnownSpaceAndFitsNowhere) {
  const TiledGrid grid = room(false);
  Points noise;  // a circle of 1.2 m radius: nothing of the kind is in the room
  for (int i = 0; i < 360; ++i)
    noise.emplace_back(1.2 * std::cos(i * M_PI / 180.0), 1.2 * std::sin(i * M_PI / 180.0));
  const LidarCheck check = check_scan(unpacked(grid), noise, {-0.8, -0.3, 0}, {0.5, 0.2, 0.02}, {});
  EXPECT_EQ(check.opinion, LidarOpinion::kNowhere) << check.reason;
}

TEST(LidarCheck, TooFewPointsSayNothing) {
  const LidarCheck check =
      check_scan(unpacked(room(false)), Points(5, {1.0, 0.0}), {0, 0, 0}, {0.5, 0.2, 0.02}, {});
  EXPECT_EQ(check.opinion, LidarOpinion::kNothing);
  EXPECT_NE(check.reason.find("too few points"), std::string::npos);
}

void add_room(SubmapStore* store, std::int64_t id, std::int64_t revision) {
  const TiledGrid grid = room(false);
  for (const auto& [at, cells] : grid.tiles())
    store->add_tile(encode_grid_tile({id, at.first, at.second, 0}, cells, kCell_m, revision, 0));
}

TEST(SubmapStore, UnpacksWhatCameAndKeepsFewUnpacked) {
  SubmapStore store(2);
  EXPECT_EQ(store.unpacked(1), nullptr);
  for (const std::int64_t id : {1, 2, 3}) add_room(&store, id, 1);
  const Raster expected = raster_from_tiles(room(false));
  for (const std::int64_t id : {1, 2, 3, 1}) {  // 1 comes back after it was dropped
    const UnpackedSubmap* submap = store.unpacked(id);
    ASSERT_NE(submap, nullptr);
    for (int x = -62; x <= 62; x += 3)
      for (int y = -42; y <= 42; y += 3) ASSERT_EQ(submap->raster.at(x, y), expected.at(x, y));
  }
}

TEST(SubmapStore, AnOlderTileDoesNotReplaceANewerOne) {
  SubmapStore store;
  add_room(&store, 1, 5);
  const std::int64_t revision = store.all().at(1).revision;
  add_room(&store, 1, 4);
  EXPECT_EQ(store.all().at(1).revision, revision);
  add_room(&store, 1, 6);
  EXPECT_GT(store.all().at(1).revision, revision);
}

TEST(SubmapStore, RemembersWhichScansASubmapHolds) {
  SubmapStore store;
  LoopScan scan;
  scan.id = 4;
  scan.utime_us = 9;
  scan.submaps = {{1, from_xyz_rpy(1, 2, 0, 0, 0, 0.5)}, {3, SE3::Identity()}};
  store.add_scan(scan);
  EXPECT_EQ(store.submaps_of(4).size(), 2U);
  EXPECT_TRUE(store.submaps_of(5).empty());
  ASSERT_EQ(store.all().at(1).members.size(), 1U);
  EXPECT_NEAR(store.all().at(1).members[0].T_submap_base.y, 2.0, 1e-12);
  EXPECT_EQ(store.all().at(3).last_utime_us, 9);
  EXPECT_EQ(store.unpacked(1), nullptr);  // no tile of it came
}

}  // namespace
}  // namespace fusion_slam
