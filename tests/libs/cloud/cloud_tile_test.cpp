#include "libs/cloud/cloud_tile.hpp"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/damaged_tile.hpp"

namespace fusion_slam {
namespace {

constexpr double kResolution = 0.025;  // a cube of 0.8 m

ColouredPoint point(double x, double y, double z) {
  ColouredPoint p;
  p.p_m = Eigen::Vector3d(x, y, z).cast<float>();
  p.r = 10;
  p.g = 20;
  p.b = 30;
  return p;
}

TEST(CloudTile, BytesAreThoseOfTheTable) {
  const double exact = 1.0 / 32.0;  // a cube of 1 m
  const Tile tile = encode_cloud_tile(
      {0, 0, -1, 0}, {point(0.5, -1.0, 0.25), point(0.0, -0.5, 0.99999)}, exact, 1, 5);
  EXPECT_EQ(tile.encoding, TileEncoding::kCloud);
  EXPECT_EQ(tile.size_cells, 32);
  const auto raw = inflate_bytes(tile.data.data(), tile.data.size(), 100000);
  ASSERT_TRUE(raw);
  const std::vector<std::uint8_t> golden = {0,  0x80, 0,   0,     // x: 0x8000, 0
                                            0,  0,    0,   0x80,  // y: 0, 0x8000
                                            0,  0x40, 255, 255,   // z: 0x4000, 0xFFFF
                                            10, 10,   20,  20,   30, 30};
  ASSERT_EQ(raw->size(), golden.size());
  EXPECT_EQ(*raw, golden);
}

TEST(CloudTile, PointsSurviveTheWireToAUnit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 0.8);
  std::vector<ColouredPoint> points;
  for (int i = 0; i < 500; ++i)
    points.push_back(point(uniform(random) - 1.6, uniform(random), uniform(random) + 0.8));
  const auto back = decode_cloud_tile(encode_cloud_tile({0, -2, 0, 1}, points, kResolution, 1, 1));
  ASSERT_TRUE(back);
  ASSERT_EQ(back->size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT(((*back)[i].p_m - points[i].p_m).cwiseAbs().maxCoeff(), 0.8 / 65536.0);
    EXPECT_EQ((*back)[i].g, 20);
  }
}

TEST(CloudTile, TooManyPointsAreThinnedAndFitADatagram) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 0.8);
  std::vector<ColouredPoint> points(20000);
  for (auto& p : points) p = point(uniform(random), uniform(random), uniform(random));
  for (auto& p : points) p.r = static_cast<std::uint8_t>(random());
  const Tile tile = encode_cloud_tile({}, points, kResolution, 1, 1);
  EXPECT_LT(tile.data.size(), 50000U);
  EXPECT_EQ(decode_cloud_tile(tile)->size(), kCloudTileMaxPoints);
}

TEST(CloudTile, EmptyAndDamaged) {
  const Tile empty = encode_cloud_tile({}, {}, kResolution, 1, 1);
  EXPECT_EQ(empty.encoding, TileEncoding::kEmpty);
  EXPECT_TRUE(decode_cloud_tile(empty)->empty());
  const Tile tile = encode_cloud_tile({}, {point(0.1, 0.2, 0.3)}, kResolution, 1, 1);
  expect_damage_is_noticed(tile, [](const Tile& t) { return decode_cloud_tile(t); });
  Tile wrong = tile;
  wrong.data = deflate_bytes(std::vector<std::uint8_t>(10, 0));
  EXPECT_FALSE(decode_cloud_tile(wrong));
}

TEST(CloudTile, TileOfAPoint) {
  const TileKey key = cloud_tile_of(0, {-0.01, 0.81, 0.0}, kResolution);
  EXPECT_TRUE(key == (TileKey{0, -1, 1, 0}));
}

TEST(CloudTile, ResolutionThatNoCloudHasIsDamage) {
  Tile tile = encode_cloud_tile({0, 1, 2, 3}, {point(0.1, 0.2, 0.3)}, kResolution, 1, 1);
  for (const double resolution_m : {1e300, 0.0, -1.0, static_cast<double>(NAN)}) {
    tile.resolution_m = resolution_m;
    EXPECT_FALSE(decode_cloud_tile(tile)) << resolution_m;
  }
}

}  // namespace
}  // namespace fusion_slam
