#include "drivers/simulator/mip_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "drivers/simulator/random.hpp"

namespace fusion_slam {
namespace {

std::vector<Texel> random_texels(int n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Texel> texels;
  for (int i = 0; i < n; ++i) {
    const std::uint64_t bits = random.bits();
    texels.push_back({static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                      static_cast<std::uint8_t>(bits >> 16), 255});
  }
  return texels;
}

// Bilinear in the full resolution, in doubles.
double slow(const std::vector<Texel>& texels, int width, int height, double x, double y,
            Beyond beyond, std::size_t channel) {
  const auto at = [&](int i, int j) {
    if (beyond == Beyond::kRepeat) {
      i = (i % width + width) % width;
      j = (j % height + height) % height;
    } else {
      i = std::clamp(i, 0, width - 1);
      j = std::clamp(j, 0, height - 1);
    }
    return static_cast<double>(texels[static_cast<std::size_t>(j * width + i)][channel]);
  };
  const int i = static_cast<int>(std::floor(x - 0.5)), j = static_cast<int>(std::floor(y - 0.5));
  const double a = x - 0.5 - i, b = y - 0.5 - j;
  return (at(i, j) * (1 - a) + at(i + 1, j) * a) * (1 - b) +
         (at(i, j + 1) * (1 - a) + at(i + 1, j + 1) * a) * b;
}

TEST(MipMap, IsBilinearUpClose) {
  for (const Beyond beyond : {Beyond::kBorder, Beyond::kRepeat}) {
    const int width = 13, height = 7;
    const auto texels = random_texels(width * height, 1);
    const MipMap picture(width, height, texels, beyond);
    Random random(2);
    for (int i = 0; i < 500; ++i) {
      const double x = random.uniform(-20, 30), y = random.uniform(-20, 30);
      const auto bgr = picture.at(static_cast<float>(x), static_cast<float>(y), 0.7F);
      for (std::size_t k = 0; k < 3; ++k)  // weights have steps of 1/128
        ASSERT_NEAR(bgr[k], slow(texels, width, height, x, y, beyond, k), 4.5);
    }
  }
}

TEST(MipMap, FarAwayIsTheMeanAndBetweenIsBetween) {
  const auto texels = random_texels(64 * 64, 3);
  const MipMap picture(64, 64, texels, Beyond::kRepeat);
  double mean = 0.0;
  for (const Texel& t : texels) mean += t[0] / 4096.0;
  EXPECT_NEAR(picture.at(10.0F, 20.0F, 64.0F)[0], mean, 1.5);
  EXPECT_NEAR(picture.at(10.0F, 20.0F, 1e6F)[0], mean, 1.5);
  const auto fine = picture.at(10.3F, 20.2F, 2.0F), coarse = picture.at(10.3F, 20.2F, 4.0F);
  EXPECT_NEAR(picture.at(10.3F, 20.2F, 3.0F)[1], 0.5F * (fine[1] + coarse[1]), 0.01);
}

TEST(MipMap, EightAtOnceAreEightTimesOne) {
  const MipMap picture(50, 31, random_texels(50 * 31, 4), Beyond::kBorder);
  const MipMap repeated(50, 31, random_texels(50 * 31, 4), Beyond::kRepeat);
  Random random(5);
  for (const float footprint : {0.5F, 1.0F, 1.7F, 9.0F, 500.0F})
    for (const MipMap* p : {&picture, &repeated}) {
      std::array<float, 8> x, y;
      for (std::size_t i = 0; i < 8; ++i) {
        x[i] = static_cast<float>(random.uniform(-60, 120));
        y[i] = static_cast<float>(random.uniform(-60, 120));
      }
      std::array<std::array<float, 4>, 8> bgr;
      p->at(x, y, footprint, &bgr);
      for (std::size_t i = 0; i < 8; ++i)
        for (std::size_t k = 0; k < 3; ++k)
          EXPECT_EQ(bgr[i][k], p->at(x[i], y[i], footprint)[k]) << footprint;
    }
}

TEST(MipMap, RefusesWrongSizes) {
  EXPECT_THROW(MipMap(2, 2, random_texels(3, 1), Beyond::kBorder), std::invalid_argument);
  EXPECT_THROW(MipMap(0, 2, {}, Beyond::kBorder), std::invalid_argument);
}

}  // namespace
}  // namespace fusion_slam
