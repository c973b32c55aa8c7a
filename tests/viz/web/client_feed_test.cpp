#include "viz/web/client_feed.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

constexpr std::int64_t kSecond = 1'000'000;

class ClientFeedTest : public ::testing::Test {
 protected:
  ClientFeedTest() { feed_.want(TopicSet().set()); }
  void fill(int n_tiles) {
    for (int i = 0; i < n_tiles; ++i)
      store_.put(Topic::kCloud, std::to_string(i),
                 std::string(50'000, static_cast<char>('a' + i % 26)));
  }
  ItemStore store_;
  ClientFeed feed_{store_};
};

TEST_F(ClientFeedTest, NothingBeforeTheFirstWant) {
  store_.put(Topic::kPose, "", "p");
  ClientFeed fresh(store_);
  EXPECT_FALSE(fresh.next(0));
  fresh.want(TopicSet().set());
  EXPECT_TRUE(fresh.next(kSecond));
}

// A browser that never acknowledges costs two batches, whatever happens to the map meanwhile.
TEST_F(ClientFeedTest, ASleepingBrowserGetsTwoBatchesAndThenNothing) {
  fill(100);
  std::size_t bytes = 0;
  for (int i = 0; i < 10'000; ++i) {
    store_.put(Topic::kPose, "", std::to_string(i));
    if (const auto batch = feed_.next(i * kSecond)) bytes += batch->size();
  }
  EXPECT_EQ(feed_.under_way(), ClientFeed::kMostUnderWay);
  EXPECT_LT(bytes, 2 * (ClientFeed::kBatchBytes + 60'000));
}

TEST_F(ClientFeedTest, WhenItWakesItGetsTheNewestFirst) {
  fill(100);
  std::uint32_t n = 0;
  while (feed_.next(0)) ++n;
  for (int i = 0; i < 1000; ++i) store_.put(Topic::kPose, "", "pose " + std::to_string(i));
  feed_.acknowledge(n);
  const auto batch = feed_.next(kSecond);
  ASSERT_TRUE(batch);
  EXPECT_NE(batch->find("pose 999"), std::string::npos);
  EXPECT_EQ(batch->find("pose 998"), std::string::npos);
}

TEST_F(ClientFeedTest, AMapArrivesAsFastAsItIsAcknowledged) {
  fill(100);
  std::size_t bytes = 0;
  std::uint32_t n = 0;
  while (const auto batch = feed_.next(0)) {  // the clock stands still: full batches need no pause
    bytes += batch->size();
    feed_.acknowledge(++n);
  }
  EXPECT_GT(bytes, 100U * 50'000U);
}

TEST_F(ClientFeedTest, SmallChangesAreGatheredForAPeriod) {
  store_.put(Topic::kPose, "", "1");
  ASSERT_TRUE(feed_.next(0));
  feed_.acknowledge(1);
  store_.put(Topic::kPose, "", "2");
  EXPECT_FALSE(feed_.next(ClientFeed::kPeriod_us - 1));
  EXPECT_TRUE(feed_.next(ClientFeed::kPeriod_us));
}

TEST_F(ClientFeedTest, NumbersThatWereNeverSentAcknowledgeNothing) {
  fill(100);
  while (feed_.next(0)) {
  }
  feed_.acknowledge(4'000'000'000U);
  EXPECT_EQ(feed_.under_way(), ClientFeed::kMostUnderWay);
  feed_.acknowledge(2);
  feed_.acknowledge(1);  // late: no step back
  EXPECT_EQ(feed_.under_way(), 0U);
}

TEST_F(ClientFeedTest, WhatIsNotWantedIsNotSentAndComesWholeLater) {
  fill(2);
  feed_.want(TopicSet().set(static_cast<std::size_t>(Topic::kPose)));
  store_.put(Topic::kPose, "", "p");
  const auto batch = feed_.next(0);
  ASSERT_TRUE(batch);
  EXPECT_LT(batch->size(), 100U);
  feed_.acknowledge(1);
  feed_.want(TopicSet().set());
  const auto rest = feed_.next(kSecond);
  ASSERT_TRUE(rest);
  EXPECT_GT(rest->size(), 100'000U);
}

}  // namespace
}  // namespace fusion_slam
