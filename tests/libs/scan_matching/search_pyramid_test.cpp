#include "libs/scan_matching/search_pyramid.hpp"

#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(SearchPyramid, EachLevelIsTheMaximumOfWhatAMovedPointCanMeet) {
  std::mt19937 rng(1);
  Raster raster(0.05, kUnknownCell);
  raster.include({-70, -10}, {60, 90});
  std::uniform_int_distribution<int> x(-128, 63), y(-64, 127), value(0, 255);
  for (int i = 0; i < 400; ++i) raster.cell(x(rng), y(rng)) = static_cast<std::uint8_t>(value(rng));
  const SearchPyramid pyramid(raster);
  for (int l = 0; l < SearchPyramid::kLevels; ++l) {
    const PyramidLevel& level = pyramid.level(l);
    const int s = level.stride(), reach = s == 1 ? 1 : 2 * s;
    for (int by = -64 / s - 4; by < 128 / s + 4; ++by)
      for (int bx = -128 / s - 4; bx < 64 / s + 4; ++bx) {
        std::uint8_t largest = 0;
        for (int cy = by * s; cy < by * s + reach; ++cy)
          for (int cx = bx * s; cx < bx * s + reach; ++cx)
            largest = std::max(largest, match_byte(raster.at(cx, cy)));
        ASSERT_EQ(level.bound(bx, by), largest) << l << " " << bx << " " << by;
      }
  }
}

}  // namespace
}  // namespace fusion_slam
