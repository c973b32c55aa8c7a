#include "libs/features/lsh_index.hpp"

#include <map>
#include <random>
#include <set>

#include <flann/flann.hpp>
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

// FLANN's index that looks at all is exact and draws nothing by lot, unlike its index by hashing.
TEST(LshIndex, SaysOfEachNeighbourWhatFlannSays) {
  std::mt19937 random(3);
  std::vector<Descriptor> all(1500);
  LshIndex index(8, 16, 7);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (auto& word : all[i]) word = (static_cast<std::uint64_t>(random()) << 32U) | random();
    // Every third is like the one before: neighbours that a descriptor of a video has.
    if (i % 3 == 2) {
      all[i] = all[i - 1];
      for (int k = 0; k < 20; ++k) all[i][random() % 4] ^= 1ULL << (random() % 64);
    }
    index.add(all[i], static_cast<int>(i));
  }
  const auto bytes = [](Descriptor& first, std::size_t n) {
    return flann::Matrix<unsigned char>(reinterpret_cast<unsigned char*>(first.data()), n,
                                        sizeof(Descriptor));
  };
  flann::Index<flann::Hamming<unsigned char>> exact(bytes(all[0], all.size()),
                                                    flann::LinearIndexParams());
  exact.buildIndex();
  std::size_t expected = 0;
  std::size_t found = 0;
  for (std::size_t q = 0; q < all.size(); q += 7) {
    std::vector<std::vector<int>> labels;
    std::vector<std::vector<unsigned int>> distances;
    exact.radiusSearch(bytes(all[q], 1), labels, distances, 49, flann::SearchParams(-1));
    std::map<int, int> near;
    for (std::size_t i = 0; i < labels[0].size(); ++i)
      near.emplace(labels[0][i], static_cast<int>(distances[0][i]));
    expected += near.size();
    for (const LshIndex::Near& n : index.near(all[q], 48)) {
      ASSERT_EQ(near.count(n.label), 1U);
      EXPECT_EQ(near.at(n.label), n.distance);
      ++found;
    }
  }
  EXPECT_GT(expected, all.size() / 7);  // more than each query itself
  EXPECT_LE(found, expected);
  EXPECT_GT(found, 0.8 * expected);
}

// After many came and went it answers as one that only ever had those that are left.
TEST(LshIndex, WhatIsRemovedWasNeverThere) {
  std::mt19937 random(5);
  LshIndex index(8, 10, 7);
  std::map<int, std::vector<Descriptor>> kept;
  for (int label = 0; label < 60; ++label) {
    for (int i = 0; i < 20; ++i) {
      Descriptor d;
      for (auto& word : d) word = random() % 16;
      kept[label].push_back(d);
      index.add(d, label);
    }
    if (label % 3 == 0) continue;
    const int gone = std::next(kept.begin(), random() % kept.size())->first;
    index.remove(gone);
    index.remove(gone);  // the second time nothing happens
    kept.erase(gone);
  }
  LshIndex anew(8, 10, 7);
  for (const auto& [label, descriptors] : kept)
    for (const Descriptor& d : descriptors) anew.add(d, label);
  EXPECT_EQ(index.size(), anew.size());
  for (int q = 0; q < 50; ++q) {
    Descriptor query;
    for (auto& word : query) word = random() % 16;
    std::multimap<int, int> is, should;
    int last = -1;
    for (const LshIndex::Near& n : index.near(query, 6)) {
      EXPECT_GE(n.label, last);
      last = n.label;
      is.emplace(n.label, n.distance);
    }
    for (const LshIndex::Near& n : anew.near(query, 6)) should.emplace(n.label, n.distance);
    EXPECT_EQ(is.size(), should.size());
    for (const auto& [label, descriptors] : kept) {
      std::multiset<int> a, b;
      for (auto [at, end] = is.equal_range(label); at != end; ++at) a.insert(at->second);
      for (auto [at, end] = should.equal_range(label); at != end; ++at) b.insert(at->second);
      EXPECT_EQ(a, b);
    }
  }
}

TEST(LshIndex, KeepOnlyIsAnIndexOfWhatIsKept) {
  std::mt19937 random(6);
  LshIndex index(8, 10, 7), anew(8, 10, 7);
  const auto wanted = [](int label) { return label % 3 == 0; };
  for (int i = 0; i < 900; ++i) {
    Descriptor d;
    for (auto& word : d) word = random() % 16;
    const int label = i % 300;
    index.add(d, label);
    if (wanted(label) && label != 6) anew.add(d, label);
  }
  index.remove(6);
  index.keep_only(wanted);
  index.keep_only([](int) { return true; });
  EXPECT_EQ(index.size(), anew.size());
  for (int q = 0; q < 50; ++q) {
    Descriptor query;
    for (auto& word : query) word = random() % 16;
    const auto is = index.near(query, 6), should = anew.near(query, 6);
    ASSERT_EQ(is.size(), should.size());
    for (std::size_t i = 0; i < is.size(); ++i) {
      EXPECT_EQ(is[i].label, should[i].label);
      EXPECT_EQ(is[i].distance, should[i].distance);
    }
  }
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
