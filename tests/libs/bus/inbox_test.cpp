#include "libs/bus/inbox.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

InboxItem item(std::size_t channel, std::int64_t utime, std::int64_t seq,
               std::int64_t arrival = 0) {
  return {channel,
          utime,
          seq,
          arrival,
          {static_cast<std::uint8_t>(utime), static_cast<std::uint8_t>(seq)}};
}

TEST(Inbox, LatestOnlyKeepsTheNewestAndCountsTheRest) {
  Inbox inbox(Mode::kLive, 10, 0);
  const auto camera = inbox.add_channel("CAMERA", Policy::kLatestOnly, false);
  for (int i = 1; i <= 5; ++i) inbox.push(item(camera, i, 0));
  const auto newest = inbox.pop(1000);
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->utime_us, 5);
  EXPECT_EQ(inbox.channels()[camera].counters.dropped, 4);
  EXPECT_FALSE(inbox.pop(1000));
}

TEST(Inbox, LatestOnlyMissesNothingThatANewerOneHasTakenThePlaceOf) {
  for (const Mode mode : {Mode::kLive, Mode::kThroughput}) {
    Inbox inbox(mode, 10, 0);
    const auto model = inbox.add_channel("ROBOT_MODEL", Policy::kLatestOnly, true);
    inbox.push(item(model, 1, 1));
    inbox.push(item(model, 5, 5));
    EXPECT_EQ(inbox.missing(model, 100, 0, 10).size(), mode == Mode::kLive ? 0U : 3U);
    inbox.expect("ROBOT_MODEL", 6, 0);
    EXPECT_EQ(inbox.missing(model, 100, 0, 10).back(), 6) << "the newest may be asked for";
    EXPECT_EQ(inbox.push(item(model, 3, 3)), mode != Mode::kLive);
  }
}

// A restart: the newest has come already when the journal is read.
TEST(Inbox, NorDoesOneThatIsBuiltUpAgain) {
  for (const Policy policy : {Policy::kLatestOnly, Policy::kKeepAll}) {
    Inbox inbox(Mode::kLive, 10, 0);
    const auto model = inbox.add_channel("ROBOT_MODEL", policy, true);
    inbox.push(item(model, 9, 9));
    for (const int handled : {1, 2, 5}) inbox.was_handled(model, handled, handled, 0);
    EXPECT_EQ(inbox.missing(model, 100, 0, 10).size(), policy == Policy::kLatestOnly ? 0U : 5U);
  }
}

TEST(Inbox, OfflineNothingIsDropped) {
  Inbox inbox(Mode::kThroughput, 2, 0);
  const auto camera = inbox.add_channel("CAMERA", Policy::kLatestOnly, false);
  for (int i = 1; i <= 5; ++i) inbox.push(item(camera, i, 0));
  EXPECT_EQ(inbox.waiting(), 5U);
}

TEST(Inbox, KeepAllIsBoundedLiveAndDropsTheOldest) {
  Inbox inbox(Mode::kLive, 3, 0);
  const auto channel = inbox.add_channel("KEYFRAME", Policy::kKeepAll, true);
  for (int i = 1; i <= 5; ++i) inbox.push(item(channel, i, i));
  EXPECT_EQ(inbox.channels()[channel].counters.dropped, 2);
  EXPECT_EQ(inbox.pop(1)->utime_us, 3);
}

TEST(Inbox, MergesByMeasurementTimeWithABoundedWait) {
  Inbox inbox(Mode::kLive, 10, 30);
  const auto a = inbox.add_channel("A", Policy::kKeepAll, true);
  const auto b = inbox.add_channel("B", Policy::kKeepAll, true);
  inbox.push(item(b, 5, 1, 100));
  EXPECT_TRUE(inbox.pop(101)) << "nobody else speaks";
  inbox.push(item(a, 10, 1, 102));
  EXPECT_FALSE(inbox.pop(103)) << "b is at 5 and may still bring something older than 10";
  inbox.push(item(b, 7, 2, 104));
  EXPECT_EQ(inbox.pop(105)->utime_us, 7);
  EXPECT_FALSE(inbox.pop(110));
  EXPECT_EQ(inbox.pop(140)->utime_us, 10) << "waited long enough";
  inbox.push(item(b, 8, 3, 141));
  EXPECT_EQ(inbox.pop(200)->utime_us, 8);
  EXPECT_EQ(inbox.channels()[b].counters.late, 1);
}

// A scan arrives 100 us after its first beam.
TEST(Inbox, WaitsOnlyForWhatCanComeInTime) {
  Inbox inbox(Mode::kLive, 10, 30);
  const auto camera = inbox.add_channel("CAMERA", Policy::kKeepAll, true);
  const auto scan = inbox.add_channel("LIDAR", Policy::kKeepAll, true);
  inbox.push(item(scan, 1000, 1, 1100));
  ASSERT_TRUE(inbox.pop(1130));
  inbox.push(item(camera, 1133, 1, 1135));
  EXPECT_EQ(inbox.pop(1135)->utime_us, 1133) << "a scan of 1133 would come at 1233: too late";
  inbox.push(item(scan, 1100, 2, 1200));
  EXPECT_EQ(inbox.pop(1200)->utime_us, 1100) << "a frame of 1100 would be here";
}

TEST(Inbox, WaitsAsLongAsTheOtherChannelTakes) {
  Inbox inbox(Mode::kLive, 10, 30);
  const auto pose = inbox.add_channel("VISUAL_POSE", Policy::kKeepAll, true);
  const auto keyframe = inbox.add_channel("KEYFRAME", Policy::kKeepAll, true);
  inbox.push(item(keyframe, 1000, 1, 1022));
  ASSERT_TRUE(inbox.pop(1060));
  inbox.push(item(pose, 1033, 1, 1043));
  EXPECT_FALSE(inbox.pop(1050)) << "a keyframe of 1033 may come at 1055";
  inbox.push(item(keyframe, 1033, 2, 1056));
  EXPECT_EQ(inbox.pop(1057)->channel, pose);
  EXPECT_EQ(inbox.pop(1057)->channel, keyframe);
  inbox.push(item(pose, 1066, 2, 1076));
  EXPECT_FALSE(inbox.pop(1093));
  EXPECT_EQ(inbox.pop(1095)->utime_us, 1066) << "13 later than the pose, and 5 for jitter: none";
}

TEST(Inbox, LockstepTakesCanonicalOrderWhateverTheArrival) {
  std::vector<InboxItem> arrivals;
  for (int i = 1; i <= 6; ++i) arrivals.push_back(item(0, 10 * (i / 2), i));
  for (int i = 1; i <= 4; ++i) arrivals.push_back(item(1, 10 * i, i));
  std::mt19937 rng(3);
  std::vector<std::pair<std::size_t, std::int64_t>> expected;
  for (int round = 0; round < 50; ++round) {
    std::shuffle(arrivals.begin(), arrivals.end(), rng);
    Inbox inbox(Mode::kLockstep, 10, 0);
    inbox.add_channel("A", Policy::kKeepAll, true);
    inbox.add_channel("B", Policy::kLatestOnly, true);
    const std::map<std::string, std::int64_t> counts{{"A", 5}, {"B", 3}};
    EXPECT_FALSE(inbox.complete(counts));
    for (const auto& arrival : arrivals) inbox.push(arrival);
    EXPECT_TRUE(inbox.complete(counts));
    std::vector<std::pair<std::size_t, std::int64_t>> order;
    for (const auto& taken : inbox.take(counts)) {
      order.emplace_back(taken.channel, taken.seq);
      inbox.processed(taken);
    }
    EXPECT_EQ(order.size(), 8U);
    EXPECT_FALSE(inbox.has_work(counts));
    EXPECT_EQ(inbox.waiting(), 2U) << "what belongs to the next step stays";
    if (round == 0) expected = order;
    EXPECT_EQ(order, expected);
  }
}

TEST(Inbox, LockstepIsNotCompleteWhileANumberIsMissing) {
  Inbox inbox(Mode::kLockstep, 10, 0);
  const auto a = inbox.add_channel("A", Policy::kKeepAll, true);
  inbox.push(item(a, 1, 1));
  inbox.push(item(a, 3, 3));
  EXPECT_FALSE(inbox.complete({{"A", 2}})) << "two arrived, but not the second";
  EXPECT_EQ(inbox.missing(a, 1000, 0, 10), (std::vector<std::int64_t>{2}));
  inbox.push(item(a, 2, 2));
  EXPECT_TRUE(inbox.complete({{"A", 2}}));
  EXPECT_EQ(inbox.take({{"A", 2}}).size(), 2U);
}

TEST(Inbox, RepeatsOfMessagesWithoutNumberAreDuplicatesInAReplay) {
  Inbox inbox(Mode::kLockstep, 10, 0);
  const auto camera = inbox.add_channel("CAMERA", Policy::kKeepAll, false);
  inbox.expect("CAMERA", 2, 0);
  EXPECT_EQ(inbox.missing(camera, 100, 50, 10), (std::vector<std::int64_t>{1, 2}));
  EXPECT_TRUE(inbox.push(item(camera, 1, 0)));
  EXPECT_FALSE(inbox.push(item(camera, 1, 0)));
  EXPECT_EQ(inbox.channels()[camera].counters.duplicated, 1);
  EXPECT_EQ(inbox.missing(camera, 100, 50, 10), (std::vector<std::int64_t>{1, 2}));
  EXPECT_TRUE(inbox.push(item(camera, 2, 0)));
  EXPECT_TRUE(inbox.missing(camera, 100, 50, 10).empty());
}

TEST(Inbox, AMessageWithoutNumberLostInTheMiddleIsAskedForUntilItIsHere) {
  Inbox inbox(Mode::kThroughput, 10, 0);
  const auto camera = inbox.add_channel("CAMERA", Policy::kKeepAll, false);
  for (const int i : {1, 2}) inbox.push(item(camera, i, 0));
  inbox.expect("CAMERA", 2, 0);
  for (const int i : {4, 5}) inbox.push(item(camera, i, 0));
  inbox.expect("CAMERA", 5, 10);
  EXPECT_TRUE(inbox.missing(camera, 20, 15, 10).empty()) << "too early";
  inbox.push(item(camera, 6, 0));
  inbox.expect("CAMERA", 6, 20);
  EXPECT_EQ(inbox.missing(camera, 30, 15, 10), (std::vector<std::int64_t>{3, 4, 5, 6}));
  for (const int i : {3, 4, 5, 6}) EXPECT_EQ(inbox.push(item(camera, i, 0)), i == 3);
  EXPECT_TRUE(inbox.missing(camera, 30, 15, 10).empty());
  inbox.expect("CAMERA", 6, 40);
  inbox.expect("CAMERA", 7, 50);
  EXPECT_EQ(inbox.missing(camera, 70, 15, 10), (std::vector<std::int64_t>{7}));
}

TEST(Inbox, AForgedCountIsAnsweredAtOnce) {
  Inbox inbox(Mode::kLockstep, 10, 0);
  const auto camera = inbox.add_channel("CAMERA", Policy::kKeepAll, false);
  inbox.expect("CAMERA", INT64_MAX, 0);
  EXPECT_EQ(inbox.missing(camera, 100, 50, 10).size(), 10U);
}

TEST(Inbox, ThroughputWaitsForTheRepairOfAGap) {
  Inbox inbox(Mode::kThroughput, 10, 0);
  const auto tiles = inbox.add_channel("TILES", Policy::kKeepAll, true);
  const auto camera = inbox.add_channel("CAMERA", Policy::kKeepAll, false);
  inbox.push(item(tiles, 30, 3));
  EXPECT_FALSE(inbox.pop(1)) << "1 and 2 are missing";
  inbox.push(item(tiles, 10, 1));
  EXPECT_FALSE(inbox.pop(1)) << "2 is missing";
  inbox.push(item(tiles, 20, 2));
  EXPECT_EQ(inbox.pop(1)->seq, 1);
  EXPECT_EQ(inbox.pop(1)->seq, 2);
  EXPECT_EQ(inbox.pop(1)->seq, 3);
  inbox.push(item(camera, 50, 0));
  inbox.expect("CAMERA", 2, 1);
  EXPECT_FALSE(inbox.pop(1)) << "two were sent, the one that came may be the newer";
  inbox.push(item(camera, 40, 0));
  EXPECT_EQ(inbox.pop(1)->utime_us, 40);
  EXPECT_EQ(inbox.pop(1)->utime_us, 50);
}

}  // namespace
}  // namespace fusion_slam
