#include "libs/submaps/changed_tiles.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

Tile tile(int x, std::uint8_t content) {
  Tile t;
  t.key.x = x;
  t.encoding = content == 0 ? TileEncoding::kEmpty : TileEncoding::kCloud;
  if (content != 0) t.data = {content};
  return t;
}

TEST(ChangedTiles, OnlyChangesPassAndRevisionsGrow) {
  ChangedTiles changed;
  EXPECT_FALSE(changed.offer(tile(1, 0)));  // never published: nothing to take back
  EXPECT_EQ(changed.offer(tile(1, 5))->revision, 1);
  EXPECT_FALSE(changed.offer(tile(1, 5)));
  EXPECT_EQ(changed.offer(tile(1, 6))->revision, 2);
  EXPECT_EQ(changed.offer(tile(2, 6))->revision, 1);
  EXPECT_EQ(changed.present().size(), 2U);
  const auto gone = changed.offer(tile(1, 0));
  ASSERT_TRUE(gone);
  EXPECT_EQ(gone->revision, 3);
  EXPECT_EQ(gone->encoding, TileEncoding::kEmpty);
  EXPECT_FALSE(changed.offer(tile(1, 0)));
  EXPECT_EQ(changed.present().size(), 1U);
}

}  // namespace
}  // namespace fusion_slam
