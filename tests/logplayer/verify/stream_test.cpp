#include "logplayer/verify/stream.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(Stream, finds_holes) {
  Stream stream("A", true);
  for (const std::int64_t seq : {4, 5, 7, 8, 12}) stream.see(seq, 1000 * seq, 10 * seq);
  const std::vector<Finding> findings = stream.finish();
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].kind, "hole");
  EXPECT_EQ(findings[0].offset_bytes, 70);
  EXPECT_EQ(findings[0].text, "A: seq 6 is missing; the message before stands at byte 50");
  EXPECT_EQ(findings[1].text,
            "A: seq 9 to 11 are missing (3 messages); the message before stands at byte 80");
}

TEST(Stream, accepts_messages_that_were_sent_again) {
  Stream stream("A", true);
  for (const std::int64_t seq : {1, 2, 5, 3, 4, 4, 6}) stream.see(seq, 1000 * seq, 0);
  EXPECT_TRUE(stream.finish().empty());
  EXPECT_EQ(stream.n_resent(), 1);
}

TEST(Stream, knows_a_publisher_that_was_started_again) {
  Stream stream("A", true);
  for (const std::int64_t seq : {1, 2, 3}) stream.see(seq, 1000 * seq, 0);
  for (const std::int64_t seq : {1, 2, 4}) stream.see(seq, 9000 + seq, seq);
  EXPECT_EQ(stream.finish().size(), 1U);  // 3 of the second run
  EXPECT_EQ(stream.n_restarts(), 1);
}

TEST(Stream, finds_measurement_time_that_goes_back) {
  Stream numbered("A", true);
  numbered.see(1, 2'000'000, 10);
  numbered.see(3, 1'900'000, 20);
  numbered.see(2, 2'000'000, 30);
  std::vector<Finding> findings = numbered.finish();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].offset_bytes, 20);
  EXPECT_EQ(findings[0].text,
            "A: measurement time goes back by 0.100000 s, from 2.000000 to 1.900000");

  Stream plain("B", true);
  for (const std::int64_t utime : {5, 5, 7, 6}) plain.see(utime, utime);
  EXPECT_EQ(plain.finish().size(), 1U);

  Stream tiles("C", false);
  tiles.see(1, 9, 0);
  tiles.see(2, 3, 0);
  EXPECT_TRUE(tiles.finish().empty());
}

TEST(Stream, survives_extreme_numbers) {
  Stream stream("A", true);
  stream.see(INT64_MIN, INT64_MAX, 0);
  stream.see(INT64_MAX, INT64_MIN, 1);
  EXPECT_EQ(stream.finish().size(), 2U);
}

}  // namespace
}  // namespace fusion_slam
