#include "libs/eventlog/summary.hpp"

#include <gtest/gtest.h>

#include "bot_core/pose_t.hpp"
#include "libs/eventlog/writer.hpp"
#include "tests/libs/eventlog/files.hpp"
#include "tests/libs/schema/encode.hpp"

namespace fusion_slam {
namespace {

TEST(Summary, counts_each_channel) {
  const TemporaryFolder folder;
  bot_core::pose_t pose{};
  LogWriter writer(folder / "s.lcm");
  for (const std::int64_t ms : {0, 100, 200, 700, 800}) {
    pose.utime = 5'000'000 + 1000 * ms;
    writer.write(9'000'000 + 1000 * ms, "POSE", encoded(pose));
  }
  writer.write(8'000'000, "FOREIGN", to_bytes("123456789"));
  writer.write(8'500'000, "FOREIGN", to_bytes("12"));
  writer.close();

  LogReader reader(folder / "s.lcm");
  const LogSummary summary = summarise(reader);
  EXPECT_EQ(summary.n_events, 7);
  EXPECT_EQ(summary.first_log_us, 8'000'000);
  EXPECT_EQ(summary.last_log_us, 9'800'000);
  EXPECT_TRUE(summary.damages.empty());
  const ChannelSummary& poses = summary.channels.at("POSE");
  EXPECT_EQ(poses.n_messages, 5);
  EXPECT_DOUBLE_EQ(poses.rate_hz(), 4 / 0.8);
  EXPECT_EQ(poses.largest_gap_us, 500'000);
  EXPECT_EQ(poses.largest_gap_begin_us, 9'200'000);
  EXPECT_EQ(poses.first_utime_us, 5'000'000);
  EXPECT_EQ(poses.last_utime_us, 5'800'000);
  EXPECT_EQ(poses.min_bytes, static_cast<std::int64_t>(encoded(pose).size()));
  EXPECT_EQ(type_name(poses.messages_by_fingerprint.begin()->first), "bot_core.pose_t");
  const ChannelSummary& foreign = summary.channels.at("FOREIGN");
  EXPECT_EQ(foreign.min_bytes, 2);
  EXPECT_EQ(foreign.max_bytes, 9);
  EXPECT_EQ(foreign.sum_bytes, 11);
  EXPECT_EQ(foreign.first_utime_us, std::nullopt);
  EXPECT_EQ(foreign.messages_by_fingerprint.count(0), 1U);
  EXPECT_EQ(type_name(foreign.messages_by_fingerprint.rbegin()->first),
            "unknown 0x3132333435363738");
}

TEST(Summary, reads_across_damages) {
  const TemporaryFolder folder;
  write_file(folder / "d.lcm",
             event_bytes(0, 1, "A", "x") + event_bytes(1, 2, "A", "y").substr(0, 20) +
                 event_bytes(2, 3, "A", "z") + event_bytes(3, 4, "A", "zz") + "\xED");
  LogReader reader(folder / "d.lcm");
  const LogSummary summary = summarise(reader);
  EXPECT_EQ(summary.n_events, 3);
  ASSERT_EQ(summary.damages.size(), 2U);
  EXPECT_FALSE(summary.damages[0].at_end);
  EXPECT_TRUE(summary.damages[1].at_end);
}

}  // namespace
}  // namespace fusion_slam
