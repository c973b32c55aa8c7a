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

TEST(Outbox, NumbersFromOneAndAnswersByNumber) {
  Outbox outbox;
  EXPECT_EQ(outbox.next_seq("A"), 1);
  for (std::uint8_t i = 1; i <= 5; ++i) outbox.sent("A", {i});
  EXPECT_EQ(outbox.next_seq("A"), 6);
  EXPECT_EQ(outbox.answer(ask("A", {2, 5, 6, 0, -1})), (std::vector<Outbox::Bytes>{{2}, {5}}));
  EXPECT_TRUE(outbox.answer(ask("B", {1})).empty());
}

TEST(Outbox, MemoryIsBounded) {
  Outbox outbox;
  for (int i = 0; i < 100; ++i) outbox.sent("A", Outbox::Bytes(1 << 20));
  EXPECT_TRUE(outbox.answer(ask("A", {1})).empty());
  EXPECT_EQ(outbox.answer(ask("A", {100})).size(), 1U);
  EXPECT_EQ(outbox.bytes("A"), 100LL << 20);
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
  EXPECT_EQ(outbox.answer(request), (std::vector<Outbox::Bytes>{{2}}));
}

}  // namespace
}  // namespace fusion_slam
