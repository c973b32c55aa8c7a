#include "libs/bus/sequence.hpp"

#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

using Seen = SequenceTracker::Seen;

TEST(Sequence, GapsAreMissingUntilTheyArrive) {
  SequenceTracker tracker(true);
  EXPECT_EQ(tracker.see(1, 10, 0), Seen::kNew);
  EXPECT_EQ(tracker.see(4, 40, 100), Seen::kNew);
  EXPECT_EQ(tracker.missing(100, 0, 10), (std::vector<std::int64_t>{2, 3}));
  EXPECT_TRUE(tracker.missing(100, 50, 10).empty());
  EXPECT_EQ(tracker.see(3, 30, 110), Seen::kNew);
  EXPECT_EQ(tracker.see(3, 30, 120), Seen::kDuplicate);
  EXPECT_EQ(tracker.missing(200, 50, 10), (std::vector<std::int64_t>{2}));
  EXPECT_EQ(tracker.give_up(200, 50), 1U);
  EXPECT_EQ(tracker.missing_count(), 0U);
  EXPECT_EQ(tracker.see(2, 50, 300), Seen::kNew) << "given up, and here all the same";
  EXPECT_EQ(tracker.see(2, 50, 300), Seen::kDuplicate);
  EXPECT_EQ(tracker.see(4, 40, 300), Seen::kDuplicate) << "not taken for a new stream";
}

TEST(Sequence, AReplayKnowsItsBeginningAndItsEnd) {
  SequenceTracker tracker(true);
  EXPECT_EQ(tracker.see(3, 1, 0), Seen::kNew);
  tracker.expect(4, 0);
  EXPECT_EQ(tracker.missing(0, 0, 10), (std::vector<std::int64_t>{1, 2, 4}));
}

TEST(Sequence, ALateListenerMissesNothingBeforeItJoinedButTakesIt) {
  SequenceTracker tracker(false);
  tracker.expect(100, 0);
  EXPECT_EQ(tracker.missing_count(), 0U);
  EXPECT_EQ(tracker.see(50, 1, 0), Seen::kNew);
  EXPECT_EQ(tracker.missing_count(), 0U);
  EXPECT_EQ(tracker.see(7, 1, 0), Seen::kNew);
  EXPECT_EQ(tracker.see(7, 1, 0), Seen::kDuplicate);
}

// A fuser that was killed asks for all tiles: old numbers come first, then those of now.
TEST(Sequence, WhatIsSentAgainToALateListenerIsNotWhereItJoins) {
  SequenceTracker tracker(false);
  tracker.expect(13'000, 0);
  EXPECT_EQ(tracker.see(12, 1, 0), Seen::kNew);
  EXPECT_EQ(tracker.see(800, 2, 0), Seen::kNew);
  EXPECT_EQ(tracker.see(800, 2, 0), Seen::kDuplicate);
  EXPECT_EQ(tracker.see(13'001, 3, 0), Seen::kNew);
  EXPECT_EQ(tracker.missing_count(), 0U) << "nothing was sent to it in vain";
  EXPECT_EQ(tracker.see(13'003, 4, 0), Seen::kNew);
  EXPECT_EQ(tracker.missing(0, 0, 10), (std::vector<std::int64_t>{13'002}));
}

TEST(Sequence, WhatIsSentAgainBeforeThePublisherSaysHowFarItIsIsNotWhereItJoinsEither) {
  SequenceTracker tracker(false);
  EXPECT_EQ(tracker.see(100, 1, 0), Seen::kNew);  // sent again, for somebody
  EXPECT_EQ(tracker.see(9'000, 2, 0), Seen::kNew);
  EXPECT_GT(tracker.missing_count(), 8'000U);
  tracker.expect(9'500, 1);
  EXPECT_EQ(tracker.missing_count(), 0U);
  EXPECT_EQ(tracker.see(100, 1, 2), Seen::kDuplicate);
  EXPECT_EQ(tracker.see(9'000, 2, 2), Seen::kDuplicate);
  EXPECT_EQ(tracker.see(200, 1, 2), Seen::kNew);
  EXPECT_EQ(tracker.see(9'502, 3, 3), Seen::kNew);
  tracker.expect(9'503, 4);
  EXPECT_EQ(tracker.missing(9, 0, 10), (std::vector<std::int64_t>{9'501, 9'503}));
}

// One that joins where the publisher is misses what comes late.
TEST(Sequence, NearThePublisherItStaysWhereItJoined) {
  SequenceTracker tracker(false);
  tracker.see(5, 1, 0);
  tracker.see(9, 2, 0);
  tracker.expect(12, 1);
  EXPECT_EQ(tracker.missing(9, 0, 10), (std::vector<std::int64_t>{6, 7, 8, 10, 11, 12}));
  SequenceTracker later(false);  // and far from there it was long ago
  later.see(1'000, 1, 0);
  later.expect(1'100, 1);
  later.expect(3'000, 2);
  EXPECT_EQ(later.missing_count(), 2'000U);
}

TEST(Sequence, ForgedCountsOverflowNothing) {
  for (const std::int64_t count : {INT64_MIN, INT64_C(-1), INT64_MAX}) {
    SequenceTracker tracker(false);
    tracker.expect(count, 0);
    EXPECT_EQ(tracker.see(5, 1, 0), Seen::kNew);
    EXPECT_EQ(tracker.see(6, 2, 0), Seen::kNew);
    EXPECT_EQ(tracker.missing_count(), 0U);
  }
}

TEST(Sequence, APublisherThatStartsAgainIsANewStream) {
  SequenceTracker tracker(true);
  for (int i = 1; i <= 5; ++i) tracker.see(i, i, 0);
  EXPECT_EQ(tracker.see(1, 1, 0), Seen::kDuplicate);
  EXPECT_EQ(tracker.see(1, 6, 0), Seen::kNew);
  EXPECT_EQ(tracker.see(2, 7, 0), Seen::kNew);
}

TEST(Sequence, ALateListenerNoticesThatThePublisherStartedAgain) {
  SequenceTracker tracker(false);
  for (int i = 50; i <= 80; ++i) tracker.see(i, i, 0);
  for (int i = 1; i <= 100; ++i) EXPECT_EQ(tracker.see(i, 1000 + i, 0), Seen::kNew) << i;
  for (int i = 1; i <= 100; ++i) EXPECT_EQ(tracker.see(i, 1000 + i, 0), Seen::kDuplicate) << i;
  EXPECT_EQ(tracker.missing_count(), 0U);
}

TEST(Sequence, ANewStreamIsNoticedWithoutItsFirstMessage) {
  SequenceTracker tracker(true);
  for (int i = 1; i <= 5; ++i) tracker.see(i, i, 0);
  EXPECT_EQ(tracker.see(2, 100, 0), Seen::kNew);
  EXPECT_EQ(tracker.see(3, 101, 0), Seen::kNew);
  EXPECT_EQ(tracker.see(3, 101, 0), Seen::kDuplicate);
}

TEST(Sequence, ForgedNumbersCostBoundedMemory) {
  SequenceTracker tracker(true);
  tracker.see(1, 1, 0);
  tracker.expect(INT64_MIN, 0);
  EXPECT_EQ(tracker.missing_count(), 0U);
  const auto most = static_cast<std::size_t>(SequenceTracker::kMostGaps);
  for (const std::int64_t seq : {90'000L, 180'000L, 1'000'000'000L, INT64_MAX - 1, INT64_MAX}) {
    tracker.see(seq, 2, 0);
    EXPECT_LE(tracker.missing_count(), most + 1) << seq;
  }
  tracker.expect(INT64_MAX, 0);
  EXPECT_GT(tracker.give_up(10, 5), most) << "what is forgotten is lost";
}

TEST(Sequence, AnyOrderWithRepeatsEndsWhole) {
  std::mt19937 rng(7);
  for (int round = 0; round < 20; ++round) {
    std::vector<std::int64_t> order;
    for (std::int64_t i = 1; i <= 200; ++i) order.insert(order.end(), {i, i});
    std::shuffle(order.begin(), order.end(), rng);
    SequenceTracker tracker(true);
    int fresh = 0;
    for (const auto seq : order) fresh += tracker.see(seq, 0, 0) == Seen::kNew ? 1 : 0;
    EXPECT_EQ(fresh, 200);
    EXPECT_EQ(tracker.missing_count(), 0U);
  }
}

TEST(SequenceTracker, AsksForWhatLiesBetweenAnEarlierProcessAndNow) {
  SequenceTracker tracker(false);
  tracker.see(8, 80, 0);
  tracker.see(6, 60, 0);  // late, before the first that came
  for (int seq = 1; seq <= 4; ++seq) tracker.was_handled(seq, 10 * seq, 5);
  EXPECT_THAT(tracker.missing(100, 0, 10), testing::ElementsAre(5, 7));
  EXPECT_EQ(tracker.see(3, 30, 6), SequenceTracker::Seen::kDuplicate);
  EXPECT_EQ(tracker.see(6, 60, 6), SequenceTracker::Seen::kDuplicate);
  EXPECT_EQ(tracker.see(5, 50, 6), SequenceTracker::Seen::kNew);
  EXPECT_EQ(tracker.highest(), 8);
}

// A journal that was written anew begins with the last number of then; the publisher was started
// again since, and counts from 1.
TEST(SequenceTracker, AnEarlierProcessHasHeardAPublisherStartAgain) {
  for (const bool heard_already : {false, true}) {
    SequenceTracker tracker(false);
    if (heard_already) tracker.see(4, 203, 0);
    tracker.was_handled(2500, 100, 5);
    tracker.was_handled(2501, 101, 5);
    for (int seq = 1; seq <= 3; ++seq) tracker.was_handled(seq, 199 + seq, 5);
    if (!heard_already) {
      EXPECT_EQ(tracker.see(4, 203, 6), SequenceTracker::Seen::kNew);
    }
    EXPECT_EQ(tracker.missing_count(), 0U) << heard_already;
    EXPECT_EQ(tracker.highest(), 4);
    tracker.see(6, 205, 7);
    EXPECT_THAT(tracker.missing(100, 0, 10), testing::ElementsAre(5));
  }
}

TEST(SequenceTracker, AfterARestartLowNumbersAreNewOnes) {
  SequenceTracker tracker(false);
  for (int seq = 1; seq <= 9; ++seq) tracker.see(seq, 10, 0);
  EXPECT_EQ(tracker.see(3, 10, 1), SequenceTracker::Seen::kDuplicate);
  tracker.restart();
  EXPECT_EQ(tracker.see(3, 10, 2), SequenceTracker::Seen::kNew);
  EXPECT_EQ(tracker.see(1, 10, 2), SequenceTracker::Seen::kNew);
  EXPECT_TRUE(tracker.missing(100, 0, 10).empty());
}

TEST(Sequence, NobodyWaitsForWhatWasNeverGiven) {
  SequenceTracker tracker(true);
  tracker.see(1, 1, 0);
  tracker.see(1001, 2, 0);
  tracker.never_given(3, 1000);
  tracker.never_given(9, 4);  // nonsense changes nothing
  EXPECT_EQ(tracker.missing(100, 0, 10), std::vector<std::int64_t>{2});
  EXPECT_EQ(tracker.give_up(100, 50), 1U) << "2 alone is lost";
}

}  // namespace
}  // namespace fusion_slam
