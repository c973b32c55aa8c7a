#include "services/visual_odometry/landmark_table.hpp"

#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

void expect_same(const LandmarkTable<int>& table, const std::map<std::int64_t, int>& slow) {
  ASSERT_EQ(table.size(), slow.size());
  EXPECT_TRUE(std::equal(table.begin(), table.end(), slow.begin()));
  for (std::int64_t id = 0; id < 2100; ++id) {
    const auto it = slow.find(id);
    const int* found = table.find(id);
    ASSERT_EQ(found != nullptr, it != slow.end()) << id;
    if (found != nullptr) {
      EXPECT_EQ(*found, it->second);
    }
  }
}

TEST(LandmarkTable, IsAMap) {
  std::mt19937 random(2);
  LandmarkTable<int> table;
  std::map<std::int64_t, int> slow;
  for (int i = 0; i < 4000; ++i) {
    const auto id = static_cast<std::int64_t>(random() % 2000);
    switch (random() % 3) {
      case 0:
        table.emplace(id, i);
        slow.emplace(id, i);
        break;
      case 1:
        table[id] = i;
        slow[id] = i;
        break;
      default:
        table.erase(id);
        slow.erase(id);
    }
  }
  expect_same(table, slow);
  EXPECT_EQ(table.find(1 << 30), nullptr);
}

TEST(LandmarkTable, CopiesAreTheirOwn) {
  LandmarkTable<int> table;
  table.emplace(7, 70);
  table.emplace(1900, 19);
  LandmarkTable<int> copy = table;
  *copy.find(7) = 1;
  copy.erase(1900);
  expect_same(table, {{7, 70}, {1900, 19}});
  expect_same(copy, {{7, 1}});
  copy = table;
  expect_same(copy, {{7, 70}, {1900, 19}});
  const LandmarkTable<int> moved = std::move(copy);
  expect_same(moved, {{7, 70}, {1900, 19}});
}

}  // namespace
}  // namespace fusion_slam
