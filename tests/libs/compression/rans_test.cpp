#include "libs/compression/rans.hpp"

#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(Rans, FrequenciesAddUpAndForgetNobody) {
  std::mt19937 random(1);
  for (int n = 1; n <= 64; ++n) {
    std::vector<std::uint32_t> counts(static_cast<std::size_t>(n));
    for (auto& count : counts) count = random() % 3 == 0 ? 0 : 1U << random() % 24;
    counts[0] = 1U << 30;
    const auto frequencies = rans_frequencies(counts);
    EXPECT_EQ(std::accumulate(frequencies.begin(), frequencies.end(), 0U), kRansOne);
    for (std::size_t i = 0; i < counts.size(); ++i) EXPECT_EQ(frequencies[i] == 0, counts[i] == 0);
  }
  EXPECT_EQ(rans_frequencies({0, 0}), (std::vector<std::uint16_t>{0, 0}));
  const auto many = rans_frequencies(std::vector<std::uint32_t>(kRansOne, 5));
  EXPECT_EQ(many, std::vector<std::uint16_t>(kRansOne, 1));
}

TEST(Rans, SymbolsComeBackAtTheirEntropy) {
  const std::vector<std::uint32_t> counts{1000, 300, 30, 1, 400};
  const auto frequencies = rans_frequencies(counts);
  std::vector<std::uint32_t> start(frequencies.size(), 0);
  for (std::size_t i = 1; i < start.size(); ++i) start[i] = start[i - 1] + frequencies[i - 1];
  std::mt19937 random(2);
  std::vector<std::size_t> said;
  double bits = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const std::uint32_t at = random() % kRansOne;
    std::size_t s = 0;
    while (s + 1 < start.size() && at >= start[s + 1]) ++s;
    said.push_back(s);
    bits += std::log2(double{kRansOne} / frequencies[s]);
  }
  RansEncoder encoder;
  for (auto s = said.rbegin(); s != said.rend(); ++s) {
    encoder.put_bits(static_cast<std::uint32_t>(*s), 3);
    encoder.put(start[*s], frequencies[*s]);
  }
  bits += 3.0 * 20000;
  std::vector<std::uint8_t> bytes{42};
  encoder.finish(&bytes);
  EXPECT_LT(8.0 * static_cast<double>(bytes.size()), 1.002 * bits + 64.0);
  RansDecoder decoder(bytes.data() + 1, bytes.size() - 1);
  for (const std::size_t s : said) {
    EXPECT_FALSE(decoder.at_end());
    ASSERT_GE(decoder.peek(), start[s]);
    ASSERT_LT(decoder.peek(), start[s] + frequencies[s]);
    decoder.take(decoder.peek() - start[s], frequencies[s]);
    ASSERT_EQ(decoder.take_bits(3), s);
  }
  EXPECT_TRUE(decoder.at_end());
}

TEST(Rans, EndsWhereTheBytesEnd) {
  const std::vector<std::uint8_t> bytes{0, 0, 1};
  EXPECT_FALSE(RansDecoder(bytes.data(), bytes.size()).at_end());
  RansEncoder encoder;
  for (unsigned i = 0; i < 100; ++i) encoder.put_bits(i, 7);
  std::vector<std::uint8_t> whole;
  encoder.finish(&whole);
  RansDecoder cut(whole.data(), whole.size() - 2);
  for (int i = 0; i < 100; ++i) cut.take_bits(7);
  EXPECT_FALSE(cut.at_end());
}

}  // namespace
}  // namespace fusion_slam
