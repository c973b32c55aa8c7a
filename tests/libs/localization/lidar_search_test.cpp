#include "libs/localization/lidar_search.hpp"

#include <gtest/gtest.h>

#include "libs/places/rival_match.hpp"
#include "libs/scan_matching/thinning.hpp"
#include "tests/libs/localization/flat_world.hpp"

namespace fusion_slam {
namespace {

TEST(LidarSearch, FindsEveryPlaceOfTheWay) {
  const FlatWorld world = flat();
  const SE2 T_map_world{-3.0, 1.0, 0.6};  // cells lie askew to the walls
  const MapGrid map(grid_of(world, T_map_world), 0.1);
  unsigned seed = 1;
  const auto way = way_through();
  for (std::size_t i = 0; i < way.size(); i += 12) {
    const SE2 truth = T_map_world * SE2{way[i].x, way[i].y, way[i].yaw + 0.9 * seed};
    const LidarFix fix =
        find_in_map(map, scan_of(world, T_map_world.inverse() * truth, ++seed), 0.9, {});
    ASSERT_TRUE(fix.found) << fix.reason;
    const SE2 error = truth.inverse() * fix.T_map_base;
    EXPECT_LT(std::hypot(error.x, error.y), 0.05);
    EXPECT_LT(std::abs(error.yaw), 0.02);
    EXPECT_GT(fix.agreement, 0.9);
    EXPECT_LT(fix.covariance(0, 0), 0.05 * 0.05);
  }
}

// The search is exact: no pose drawn at random scores more than its best.
TEST(LidarSearch, NoOtherPlaceIsBetter) {
  const FlatWorld world = flat();
  const MapGrid map(grid_of(world), 0.1);
  const Points scan = scan_of(world, {6.0, 2.0, 1.0}, 5);
  const MapSearchConfig config;
  const LidarFix fix = find_in_map(map, scan, 1.0, config);
  ASSERT_TRUE(fix.found);
  const Points coarse = thinned(scan, config.search_points);
  std::mt19937 rng(2);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(rng() % 100'000) / 100'000.0;
  };
  for (int n = 0; n < 1000; ++n) {
    const SE2 T{uniform(0, 9), uniform(0, 6), uniform(-M_PI, M_PI)};
    EXPECT_LE(match_score(map.coarse, coarse, T), fix.score + 1e-6);
  }
}

TEST(LidarSearch, ABareRoomHasARival) {
  const FlatWorld world = bare_room();
  const MapGrid map(grid_of(world), 0.1);
  const LidarFix fix = find_in_map(map, scan_of(world, {3.0, 2.0, 0.3}, 5), 0.9, {});
  EXPECT_GT(fix.rival_score, 0.9 * fix.score);  // turned by half a turn
}

TEST(LidarSearch, AnotherBuildingIsRefused) {
  FlatWorld other;
  other.walls = {
      {{0, 0}, {2.1, 0.4}}, {{2.1, 0.4}, {2.6, 2}}, {{2.6, 2}, {0.5, 2.9}}, {{0.5, 2.9}, {0, 0}}};
  const MapGrid map(grid_of(flat()), 0.1);
  const LidarFix fix = find_in_map(map, scan_of(other, {1.2, 1.2, 0.3}, 5), 0.9, {});
  EXPECT_FALSE(fix.found);
  EXPECT_FALSE(fix.reason.empty());
  EXPECT_FALSE(find_in_map(map, Points(10, Eigen::Vector2d(1, 1)), 0.9, {}).found);  // too few
}

}  // namespace
}  // namespace fusion_slam
