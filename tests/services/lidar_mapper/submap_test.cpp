#include "services/lidar_mapper/submap.hpp"

#include <set>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(ActiveSubmaps, TwoOverlapAndAFullOneIsHandedOver) {
  LidarMapperConfig config;
  config.nodes_per_half_submap = 5;
  ActiveSubmaps submaps(0.05, config);
  ScanPoints scan;
  scan.hits_base = {{1.0, 0.0}, {0.0, 1.0}};
  for (std::int64_t id = 1; id <= 31; ++id) {
    const SE2 T_odom_base{0.1 * static_cast<double>(id), 0.0, 0.2};
    const auto last = submaps.insert(id, scan, T_odom_base, id);
    // Started at 1, 6, 11 ...; each holds ten scans.
    std::set<std::int64_t> expected;
    for (std::int64_t anchor = 1; anchor <= id; anchor += 5)
      if (id < anchor + 10) expected.insert(anchor);
    std::set<std::int64_t> got;
    for (const auto& m : submaps.inserted_into()) {
      got.insert(m.submap_id);
      const SE2 anchor{0.1 * static_cast<double>(m.submap_id), 0.0, 0.2};
      EXPECT_NEAR((anchor * m.T_submap_base).x, T_odom_base.x, 1e-9);
    }
    EXPECT_EQ(got, expected) << id;
    EXPECT_EQ(!last.empty(), id >= 10 && id % 5 == 0);
    EXPECT_FALSE(submaps.empty());
  }
}

TEST(Submap, RevisionsGrowAndUnchangedTilesStayHome) {
  const LidarMapperConfig config;
  Submap submap(7, {1.0, 2.0, 0.3}, 0.05, config);
  ScanPoints scan;
  scan.hits_base = {{1.0, 0.5}};
  submap.insert(scan, {1.0, 2.0, 0.3}, 100);
  auto tiles = submap.take_changed_tiles();
  ASSERT_EQ(tiles.size(), 1U);
  EXPECT_EQ(tiles[0].key,
            (TileKey{7, 0, 0, 0}));  // the anchor's own frame: the base sits in cell (0, 0)
  EXPECT_EQ(tiles[0].revision, 1);
  EXPECT_EQ(tiles[0].utime_us, 100);
  const auto cells = decode_grid_tile(tiles[0]);
  ASSERT_TRUE(cells);
  EXPECT_GT((*cells)[10 * 64 + 20], cell_from_probability(0.5));
  EXPECT_TRUE(submap.take_changed_tiles().empty());
  submap.insert(scan, {1.0, 2.0, 0.3}, 200);
  EXPECT_EQ(submap.take_changed_tiles().at(0).revision, 2);
}

}  // namespace
}  // namespace fusion_slam
