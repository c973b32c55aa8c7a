#include "libs/features/matching.hpp"

#include <bitset>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

Descriptor random_descriptor(std::mt19937* random) {
  Descriptor d;
  for (auto& word : d) word = (static_cast<std::uint64_t>((*random)()) << 32U) | (*random)();
  return d;
}

Descriptor with_flipped_bits(Descriptor d, int n, std::mt19937* random) {
  for (int i = 0; i < n; ++i) {
    const unsigned bit = (*random)() % 256;
    d[bit / 64] ^= 1ULL << (bit % 64);
  }
  return d;
}

TEST(Matching, HammingCountsBits) {
  std::mt19937 random(1);
  const Descriptor a = random_descriptor(&random);
  const Descriptor b = random_descriptor(&random);
  std::size_t expected = 0;
  for (int i = 0; i < 4; ++i) expected += std::bitset<64>(a[i] ^ b[i]).count();
  EXPECT_EQ(hamming(a, b), static_cast<int>(expected));
  EXPECT_EQ(hamming(a, a), 0);
}

TEST(Matching, BytesAndBack) {
  std::mt19937 random(2);
  const Descriptor a = random_descriptor(&random);
  std::array<std::uint8_t, kDescriptorBytes> bytes{};
  descriptor_to_bytes(a, bytes.data());
  EXPECT_EQ(descriptor_from_bytes(bytes.data()), a);
}

TEST(Matching, FindsPairsAndLeavesStrangersAlone) {
  std::mt19937 random(3);
  std::vector<Descriptor> a;
  std::vector<Descriptor> b;
  for (int i = 0; i < 50; ++i) a.push_back(random_descriptor(&random));
  for (int i = 0; i < 30; ++i) b.push_back(with_flipped_bits(a[49 - i], 20, &random));
  for (int i = 0; i < 20; ++i) b.push_back(random_descriptor(&random));
  const auto matches = match_mutual(a, b);
  ASSERT_EQ(matches.size(), 30U);
  for (const Match& m : matches) EXPECT_EQ(m.a, 49 - m.b);
}

TEST(Matching, TwoEquallyGoodCandidatesAreNoMatch) {
  std::mt19937 random(4);
  const Descriptor a = random_descriptor(&random);
  const Descriptor near = with_flipped_bits(a, 10, &random);
  EXPECT_TRUE(match_mutual({a}, {near, near}).empty());
  EXPECT_EQ(match_mutual({a}, {near}).size(), 1U);
  EXPECT_TRUE(match_mutual({}, {near}).empty());
  EXPECT_TRUE(match_mutual({a}, {}).empty());
}

TEST(Matching, CommonRotationDropsTheOthers) {
  std::vector<float> angles_a;
  std::vector<float> angles_b;
  std::vector<Match> matches;
  for (int i = 0; i < 40; ++i) {
    angles_a.push_back(static_cast<float>(0.15 * i));
    // Three of four turn by -0.1 rad, which wraps around; the others by anything.
    const double turn = i % 4 == 0 ? 1.0 + 0.1 * i : -0.1;
    angles_b.push_back(static_cast<float>(std::fmod(0.15 * i + turn + 2.0 * M_PI, 2.0 * M_PI)));
    matches.push_back({i, i, 0});
  }
  const auto kept = keep_common_rotation(matches, angles_a, angles_b);
  EXPECT_EQ(kept.size(), 30U);
  for (const Match& m : kept) EXPECT_NE(m.a % 4, 0);
}

}  // namespace
}  // namespace fusion_slam
