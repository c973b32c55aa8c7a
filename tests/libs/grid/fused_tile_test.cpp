#include "libs/grid/fused_tile.hpp"

#include <gtest/gtest.h>

#include "tests/support/damaged_tile.hpp"

namespace fusion_slam {
namespace {

FusedCells example() {
  FusedCells cells;
  cells.probability[0] = 255;
  cells.provenance[0] = 4;
  cells.probability[65] = 1;  // x 1, y 1
  cells.provenance[65] = 2;
  return cells;
}

TEST(FusedTile, BytesAreThoseOfTheTable) {
  const Tile tile = encode_fused_tile({0, -2, 5, 0}, example(), 0.05, 3, 77);
  EXPECT_EQ(tile.encoding, TileEncoding::kGridFused);
  EXPECT_EQ(tile.size_cells, 64);
  EXPECT_EQ(tile.revision, 3);
  EXPECT_EQ(tile.utime_us, 77);
  const auto raw = inflate_bytes(tile.data.data(), tile.data.size(), 100000);
  ASSERT_TRUE(raw);
  std::vector<std::uint8_t> golden(8192, 0);
  golden[0] = 255;
  golden[65] = 1;
  golden[4096] = 4;
  golden[4096 + 65] = 2;
  EXPECT_EQ(*raw, golden);
}

TEST(FusedTile, SurvivesTheWire) {
  const auto back = decode_fused_tile(encode_fused_tile({}, example(), 0.05, 1, 1));
  ASSERT_TRUE(back);
  EXPECT_TRUE(*back == example());
}

TEST(FusedTile, DamageGivesNothing) {
  Tile tile = encode_fused_tile({}, example(), 0.05, 1, 1);
  expect_damage_is_noticed(tile, [](const Tile& t) { return decode_fused_tile(t); });
  std::vector<std::uint8_t> raw(8192, 5);  // no such provenance
  tile.data = deflate_bytes(raw);
  EXPECT_FALSE(decode_fused_tile(tile));
  tile.data = deflate_bytes(std::vector<std::uint8_t>(8193, 0));
  EXPECT_FALSE(decode_fused_tile(tile));
  tile.encoding = TileEncoding::kGridProbability;
  EXPECT_FALSE(decode_fused_tile(tile));
}

}  // namespace
}  // namespace fusion_slam
