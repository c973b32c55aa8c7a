#include "libs/features/lsh_index.hpp"

#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(LshIndex, FindsMostOfWhatASearchThroughAllFindsAndNothingElse) {
  std::mt19937 random(1);
  std::vector<Descriptor> all;
  LshIndex index(8, 16, 7);
  for (int i = 0; i < 2000; ++i) {
    Descriptor d;
    for (auto& word : d) word = (static_cast<std::uint64_t>(random()) << 32U) | random();
    all.push_back(d);
    index.add(d, i);
  }
  EXPECT_EQ(index.size(), 2000U);
  int expected = 0;
  int found = 0;
  for (int q = 0; q < 300; ++q) {
    Descriptor query = all[random() % all.size()];
    for (int k = 0; k < 25; ++k) {
      const unsigned bit = random() % 256;
      query[bit / 64] ^= 1ULL << (bit % 64);
    }
    for (const Descriptor& d : all) expected += hamming(d, query) <= 48 ? 1 : 0;
    for (const LshIndex::Near& n : index.near(query, 48)) {
      EXPECT_EQ(n.distance, hamming(all[n.label], query));
      EXPECT_LE(n.distance, 48);
      ++found;
    }
  }
  EXPECT_LE(found, expected);
  EXPECT_GT(found, 0.7 * expected);
}

TEST(LshIndex, TwoOfTheSameSeedAreTheSame) {
  LshIndex a(4, 12, 3);
  LshIndex b(4, 12, 3);
  std::mt19937 random(2);
  Descriptor d{};
  for (int i = 0; i < 200; ++i) {
    d[i % 4] ^= random();
    a.add(d, i);
    b.add(d, i);
  }
  const auto in_a = a.near(d, 200);
  const auto in_b = b.near(d, 200);
  ASSERT_EQ(in_a.size(), in_b.size());
  ASSERT_FALSE(in_a.empty());
  for (std::size_t i = 0; i < in_a.size(); ++i) EXPECT_EQ(in_a[i].label, in_b[i].label);
}

}  // namespace
}  // namespace fusion_slam
