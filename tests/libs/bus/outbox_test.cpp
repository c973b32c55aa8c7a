#include "libs/bus/outbox.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

resend_t ask(const std::string& channel, std::vector<std::int64_t> seqs) {
  resend_t request{};
  request.channel = channel;
  request.seqs = std::move(seqs);
  return request;
}

std::vector<Outbox::Bytes> answer(Outbox& outbox, const resend_t& request) {
  outbox.request(request);
  std::vector<Outbox::Bytes> all;
  while (auto message = outbox.take_requested()) all.push_back(std::move(message->second));
  return all;
}

TEST(Outbox, NumbersFromOneAndAnswersByNumber) {
  Outbox outbox;
  EXPECT_EQ(outbox.next_seq("A"), 1);
  for (std::uint8_t i = 1; i <= 5; ++i) outbox.sent("A", {i});
  EXPECT_EQ(outbox.next_seq("A"), 6);
  EXPECT_EQ(answer(outbox, ask("A", {2, 5, 6, 0, -1})), (std::vector<Outbox::Bytes>{{2}, {5}}));
  EXPECT_TRUE(answer(outbox, ask("B", {1})).empty());
}

TEST(Outbox, SaysOfNumbersThatWereNeverGivenFromWhereToWhere) {
  Outbox outbox;
  for (std::uint8_t i = 1; i <= 3; ++i) outbox.sent("A", {i});
  outbox.skip_to("A", 2);  // reached already
  EXPECT_EQ(outbox.next_seq("A"), 4);
  outbox.skip_to("A", 1000);
  EXPECT_EQ(outbox.next_seq("A"), 1001);
  outbox.sent("A", {9});
  EXPECT_EQ(answer(outbox, ask("A", {2, 4, 500, 1000, 1001})),
            (std::vector<Outbox::Bytes>{{2}, {9}}));
  const auto told = outbox.take_never_given();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].channel, "A");
  EXPECT_EQ(told[0].seqs, (std::vector<std::int64_t>{-4, -1000}));
  EXPECT_EQ(told[0].n_seqs, 2);
  EXPECT_TRUE(outbox.take_never_given().empty());
  outbox.request(told[0]);  // what others say of it is no request
  EXPECT_FALSE(outbox.take_requested().has_value());
  EXPECT_TRUE(outbox.take_never_given().empty());
}

TEST(Outbox, MemoryIsBounded) {
  Outbox outbox;
  for (int i = 0; i < 100; ++i) outbox.sent("A", Outbox::Bytes(1 << 20));
  EXPECT_TRUE(answer(outbox, ask("A", {1})).empty());
  EXPECT_EQ(answer(outbox, ask("A", {100})).size(), 1U);
  EXPECT_EQ(outbox.bytes("A"), 100LL << 20);
}

TEST(Outbox, WhatIsAskedForOftenIsSentOnce) {
  Outbox outbox;
  for (std::uint8_t i = 1; i <= 3; ++i) outbox.sent("A", {i});
  for (int i = 0; i < 1000; ++i) outbox.request(ask("A", {2, 2, 3}));
  EXPECT_EQ(outbox.take_requested()->second, Outbox::Bytes{2});
  EXPECT_EQ(answer(outbox, ask("A", {2})), (std::vector<Outbox::Bytes>{{3}, {2}}));
  EXPECT_FALSE(outbox.take_requested());
}

TEST(Outbox, WhatIsSentOnceIsCountedAndNotKept) {
  Outbox outbox;
  outbox.sent_once("STATUS", 100);
  EXPECT_EQ(outbox.next_seq("STATUS"), 2);
  EXPECT_EQ(outbox.bytes("STATUS"), 100);
  EXPECT_TRUE(answer(outbox, ask("STATUS", {1})).empty());
}

TEST(Outbox, KeepsTheNewestTileOfEachKeyAndListsThem) {
  Outbox outbox;
  for (int i = 0; i < 2000; ++i) outbox.sent_tile("GRID", {0, i, 0, 0}, 1, {1});
  outbox.sent_tile("GRID", {0, 7, 0, 0}, 2, {2});
  const auto indexes = outbox.indexes();
  ASSERT_EQ(indexes.size(), 2U);
  EXPECT_EQ(indexes[0].n + indexes[1].n, 2000);
  EXPECT_EQ(indexes[1].part, 1);
  EXPECT_EQ(indexes[1].n_parts, 2);
  EXPECT_EQ(indexes[0].revision[7], 2);
  EXPECT_LT(indexes[0].getEncodedSize(), 60'000);
  resend_t request = ask("GRID", {});
  request.submap_id = {0, 9};
  request.x = {7, 7};
  request.y = {0, 0};
  request.z = {0, 0};
  EXPECT_EQ(answer(outbox, request), (std::vector<Outbox::Bytes>{{2}}));
}

}  // namespace
}  // namespace fusion_slam
