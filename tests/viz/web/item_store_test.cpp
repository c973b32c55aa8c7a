#include "viz/web/item_store.hpp"

#include <map>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TopicSet all() { return TopicSet().set(); }

// What a browser holds, kept as the page does it.
struct Browser {
  Cursor cursor;
  std::map<std::pair<int, std::string>, std::string> held;

  void take(const ItemStore& store, std::size_t max_bytes) {
    const std::uint64_t epoch = cursor.epoch;
    const auto items = store.next(&cursor, all(), max_bytes);
    if (cursor.epoch != epoch) held.clear();
    for (const Item& item : items) {
      const auto key = std::make_pair(static_cast<int>(item.topic), item.key);
      if (item.payload)
        held[key] = *item.payload;
      else
        held.erase(key);
    }
  }
};

TEST(ItemStore, SendsTheNewestValueOnly) {
  ItemStore store;
  store.put(Topic::kPose, "", "old");
  store.put(Topic::kPose, "", "new");
  Cursor cursor;
  const auto items = store.next(&cursor, all(), 1000);
  ASSERT_EQ(items.size(), 1U);
  EXPECT_EQ(*items[0].payload, "new");
  EXPECT_TRUE(store.next(&cursor, all(), 1000).empty());
}

TEST(ItemStore, AnEqualValueIsNoChange) {
  ItemStore store;
  store.put(Topic::kHealth, "fuser", "well");
  Cursor cursor;
  store.next(&cursor, all(), 1000);
  store.put(Topic::kHealth, "fuser", "well");
  EXPECT_TRUE(store.next(&cursor, all(), 1000).empty());
}

TEST(ItemStore, SmallTopicsOvertakeLargeOnes) {
  ItemStore store;
  for (int i = 0; i < 100; ++i) store.put(Topic::kCloud, std::to_string(i), std::string(1000, 'x'));
  Cursor cursor;
  store.next(&cursor, all(), 5000);
  store.put(Topic::kPose, "", "here");
  const auto items = store.next(&cursor, all(), 5000);
  EXPECT_EQ(items[0].topic, Topic::kPose);
}

TEST(ItemStore, ABatchEndsAtItsBoundButHoldsOneItemAtLeast) {
  ItemStore store;
  for (int i = 0; i < 10; ++i) store.put(Topic::kCloud, std::to_string(i), std::string(1000, 'x'));
  Cursor cursor;
  EXPECT_EQ(store.next(&cursor, all(), 1).size(), 1U);
  EXPECT_EQ(store.next(&cursor, all(), 2500).size(), 3U);
}

TEST(ItemStore, WhoNeverHadAnItemIsNotToldThatItIsGone) {
  ItemStore store;
  store.put(Topic::kCloud, "a", "1");
  Cursor early;
  store.next(&early, all(), 1000);
  store.remove(Topic::kCloud, "a");
  ASSERT_EQ(store.next(&early, all(), 1000).size(), 1U);
  Cursor late;
  EXPECT_TRUE(store.next(&late, all(), 1000).empty());
  EXPECT_EQ(store.size(Topic::kCloud), 0U);
}

TEST(ItemStore, RewindSendsATopicAgain) {
  ItemStore store;
  store.put(Topic::kCloud, "a", "1");
  store.put(Topic::kPose, "", "p");
  Cursor cursor;
  store.next(&cursor, all(), 1000);
  ItemStore::rewind(&cursor, Topic::kCloud);
  const auto items = store.next(&cursor, all(), 1000);
  ASSERT_EQ(items.size(), 1U);
  EXPECT_EQ(items[0].topic, Topic::kCloud);
}

// Whatever happens in between and however seldom a browser looks: in the end it holds what the
// store holds.
TEST(ItemStore, EveryBrowserEndsUpWithTheStore) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    ItemStore store;
    std::map<std::pair<int, std::string>, std::string> truth;
    std::vector<Browser> browsers(3);
    for (int step = 0; step < 600; ++step) {
      const int topic = static_cast<int>(random() % 3);
      const std::string key(1, static_cast<char>('a' + random() % 6));
      const auto what = random() % 100;
      if (what < 70) {
        const std::string value = std::to_string(random() % 50);
        store.put(static_cast<Topic>(topic), key, value);
        truth[{topic, key}] = value;
      } else if (what < 90) {
        store.remove(static_cast<Topic>(topic), key);
        truth.erase({topic, key});
      } else if (what < 92) {
        store.clear();
        truth.clear();
      } else if (what < 94) {
        store.remove_all(static_cast<Topic>(topic));
        for (auto it = truth.begin(); it != truth.end();)
          it = it->first.first == topic ? truth.erase(it) : std::next(it);
      }
      for (std::size_t i = 0; i < browsers.size(); ++i)
        if (random() % (1 + 10 * i) == 0) browsers[i].take(store, 1 + random() % 20);
    }
    for (Browser& browser : browsers) {
      for (int i = 0; i < 30; ++i) browser.take(store, 100);
      EXPECT_EQ(browser.held, truth) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace fusion_slam
